"""Polygons are triangulated without flips, seams follow their edges, and results refer to polygons."""

from __future__ import annotations

import itertools
import warnings
from pathlib import Path

import igl
import numpy as np
import pytest
from carried import dual, quads, torus_of_quads
from hypothesis import given, settings
from hypothesis import strategies as st

from igl_linabf import ChartOptions, MeshError, MeshWarning, unwrap
from igl_linabf.charts import texture_seams
from igl_linabf.io import read_file, write_file, write_mesh
from igl_linabf.surface import Polygons


def list_edges(F: object) -> set[tuple[int, int]]:
    polygons = Polygons.from_faces(F)
    pairs = np.column_stack((polygons.corners, polygons.corners[polygons.next_corner]))
    return set(map(tuple, np.sort(pairs, axis=1).tolist()))


def flat(rows: object) -> np.ndarray:
    return np.concatenate([np.ravel(row) for row in rows])


def star(k: int, seed: int) -> np.ndarray:
    """Return a simple polygon around the origin, usually concave, in a random plane."""
    rng = np.random.default_rng(seed)
    angle = (np.arange(k) + 0.8 * rng.random(k)) * 2 * np.pi / k
    arm = 0.1 + rng.random(k)
    basis = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    return np.column_stack((arm * np.cos(angle), arm * np.sin(angle))) @ basis[:2] + rng.normal(size=3)


def signed_areas(points: np.ndarray, F: np.ndarray) -> tuple[np.ndarray, float]:
    """Return the areas of triangles relative to the polygon's normal, and the area of the polygon."""
    centred = points - points.mean(axis=0)
    normal = np.cross(centred, np.roll(centred, -1, axis=0)).sum(axis=0) / 2
    area = np.linalg.norm(normal)
    a, b, c = points[F.T]
    return np.cross(b - a, c - a) @ normal / area / 2, area


@settings(max_examples=60, deadline=None)
@given(st.integers(4, 12) | st.sampled_from([40, 230]), st.integers(0, 2**32 - 1))
def test_triangles_of_a_simple_polygon_are_not_flipped(k: int, seed: int) -> None:
    points = star(k, seed)
    triangles = Polygons.from_faces([list(range(k))]).triangulate(points)
    areas, whole = signed_areas(points, triangles.F)
    assert len(areas) == k - 2
    assert areas.min() > -1e-12
    assert np.isclose(areas.sum(), whole)
    assert set(triangles.F.ravel().tolist()) == set(range(k))  # each corner is a corner of a triangle


def test_a_corner_on_a_straight_side_keeps_its_triangle() -> None:
    points = np.array([[0.0, 0, 0], [1, 0, 0], [2, 0, 0], [3, 0, 0], [3, 1, 0], [0, 1, 0]])
    triangles = Polygons.from_faces([[0, 1, 2, 3, 4, 5]]).triangulate(points).F
    assert signed_areas(points, triangles)[0].min() > 0.1
    assert set(triangles.ravel().tolist()) == set(range(6))


@pytest.mark.parametrize(
    "F",
    [
        # two coincident faces of opposite orientation must not share a diagonal
        [[0, 1, 2, 3], [0, 3, 2, 1]],
        [[0, 1, 2, 3], [0, 2, 4]],
        [[0, 1, 2, 3], [0, 2, 4, 5], [4, 2, 6]],
        [[0, 1, 2, 3, 7], [0, 7, 3, 2, 1]],
        [[0, 1, 2, 3, 7], [7, 3, 2, 1, 0], [1, 3, 4]],
    ],
)
def test_no_diagonal_is_an_edge_or_a_diagonal_of_another_polygon(F: list[list[int]]) -> None:
    V = np.array([[0, 0, 0], [2, 0, 0], [2, 2, 0], [0, 2, 0], [3, 3, 1], [1, 1, 3], [5, 4, 2], [-1, 1, 0.0]])
    made = Polygons.from_faces(F).triangulate(V)
    owners: dict[tuple[int, ...], set[int]] = {}
    for corner, face in zip(made.F.tolist(), made.face.tolist(), strict=True):
        for pair in itertools.pairwise([*corner, corner[0]]):
            owners.setdefault(tuple(sorted(pair)), set()).add(face)
    t, k = np.nonzero(made.inner)
    diagonals = np.sort(np.column_stack((made.F[t, k], made.F[t, (k + 1) % 3])), axis=1)
    assert len(diagonals) == 2 * sum(len(row) - 3 for row in F)
    assert all(len(owners[pair]) == 1 for pair in map(tuple, diagonals.tolist()))
    assert not set(map(tuple, diagonals.tolist())) & list_edges(F)


@pytest.mark.parametrize("name", ["rough cube", "torus", "dual"])
def test_seams_follow_edges_of_polygons(name: str) -> None:
    V, F = {"rough cube": quads, "torus": torus_of_quads, "dual": dual}[name]()
    atlas = unwrap(V, F, progress=False)
    assert atlas.good
    assert not atlas.report.repairs
    assert len(atlas.seams)
    assert set(map(tuple, np.sort(atlas.seams, axis=1).tolist())) <= list_edges(F)
    assert [len(row) for row in atlas.FTC] == [len(row) for row in F]
    assert (atlas.origin[flat(atlas.FTC)] == flat(F)).all()
    assert len(atlas.chart) == len(F)
    # the coordinates at a corner are the same in all triangles of its polygon
    assert (atlas.origin[atlas.triangles] == atlas.report.split.F).all()
    textures = texture_seams(F, atlas.FTC)
    assert set(map(tuple, np.sort(textures, axis=1).tolist())) == set(
        map(tuple, np.sort(atlas.seams, axis=1).tolist())
    )


def test_overlaps_are_split_along_edges_of_polygons() -> None:
    """The flat map of a coiled strip of quadrangles, 1.5 turns in its plane, overlaps itself."""
    t = np.repeat(np.linspace(0, 9, 37), 2)
    radius = np.tile([1.0, 0.8], 37)
    V = np.column_stack((radius * np.cos(t), radius * np.sin(t), 0.02 * t))
    i = 2 * np.arange(36)
    F = np.column_stack((i, i + 1, i + 3, i + 2))
    atlas = unwrap(V, F, progress=False)
    assert atlas.good
    assert atlas.report.n_splits
    assert set(map(tuple, np.sort(atlas.seams, axis=1).tolist())) <= list_edges(F)


def test_stretch_is_bounded_by_cuts_along_edges_of_polygons() -> None:
    V, F = torus_of_quads()
    atlas = unwrap(V, F, charts=ChartOptions(max_stretch=1.005), progress=False)
    assert atlas.good
    assert len(atlas.charts) > 1
    assert set(map(tuple, np.sort(atlas.seams, axis=1).tolist())) <= list_edges(F)


def test_given_seams_are_edges_of_polygons() -> None:
    V, F = torus_of_quads()
    around = [(i, i + 1) for i in range(15)] + [(15, 0)]
    along = [(16 * i, 16 * (i + 1) % (16 * 30)) for i in range(30)]
    by_pairs = unwrap(V, F, [*around, *along], progress=False)
    mask = np.array([[(min(e), max(e)) in {tuple(sorted(p)) for p in (*around, *along)} for e in
                      itertools.pairwise([*row, row[0]])] for row in F.tolist()])  # fmt: skip
    by_mask = unwrap(V, F, mask, progress=False)
    assert (by_pairs.FTC == by_mask.FTC).all()
    with pytest.raises(MeshError, match=r"seam edges 0 are (diagonals|not edges)"):
        unwrap(V, F, [F[0, [0, 2]]])


DEGENERATE = {
    "a corner twice": [[4, 5, 7, 7, 6], [0, 1, 5, 4]],
    "a triangle as a quadrangle": [[4, 5, 7, 7], [7, 6, 4, 4], [0, 1, 5, 4]],
    "one point": [[4, 4, 4, 4], [4, 5, 7, 6], [0, 1, 5, 4]],
    "an edge": [[4, 5, 5, 4], [4, 5, 7, 6], [0, 1, 5, 4]],
    "crossing itself": [[4, 7, 5, 6], [0, 1, 5, 4]],
    "both faces of a card": [[4, 5, 7, 6], [6, 7, 5, 4]],
    "the same twice": [[4, 5, 7, 6], [4, 5, 7, 6]],
    "turned": [[4, 5, 7, 6], [4, 5, 1, 0]],
    "a vertex three times": [[4, 5, 7, 4, 6, 7, 4, 5], [0, 1, 5, 4]],
}


@pytest.mark.filterwarnings("ignore::igl_linabf.MeshWarning", "ignore::igl_linabf.OutcomeWarning")
@pytest.mark.parametrize("name", DEGENERATE)
def test_degenerate_polygons_keep_their_rows(name: str) -> None:
    V = np.array([[x, y, z] for z in (0.0, 1) for y in (0, 1) for x in (0, 1)])
    F = [[0, 2, 3, 1], *DEGENERATE[name], [1, 3, 7, 5]]
    atlas = unwrap(V, F, progress=False)
    assert [len(row) for row in atlas.FTC] == [len(row) for row in F]
    assert np.isfinite(atlas.TC[flat(atlas.FTC)]).all()
    assert flat(atlas.FTC).min() >= 0


def test_invalid_faces_are_named() -> None:
    V, F = quads()
    for bad, said in (
        ([*F.tolist(), [0, 1]], "faces 96 have fewer than three corners"),
        ([*F.tolist(), [0, 1, 2, len(V)]], "faces 96 refer to vertices outside"),
        ([*F.tolist(), [0, 1, 2, 0.5]], "faces 96 have entries that are not vertex indices"),
    ):
        with pytest.raises(MeshError, match=said):
            unwrap(V, bad)


@pytest.mark.parametrize(
    ("suffix", "name"),
    [
        *itertools.product((".obj", ".ply", ".vtp"), ("quads", "dual")),
        (".glb", "quads"),
    ],  # glTF stores a polygon as a fan of triangles
)
def test_polygons_survive_a_round_trip_through_files(tmp_path: Path, suffix: str, name: str) -> None:
    V, F = {"quads": quads, "dual": dual}[name]()
    atlas = unwrap(V, F, progress=False)
    path = tmp_path / f"mesh{suffix}"
    write_mesh(path, V, F, atlas.TC, atlas.FTC)
    back = read_file(path)
    wanted = [{tuple(np.round(p, 5)) for p in V[list(row)].tolist()} for row in F]
    assert [{tuple(np.round(p, 5)) for p in back.V[list(row)].tolist()} for row in back.F] == wanted
    write_file(tmp_path / "again.obj", back, np.zeros((1, 2)), [np.zeros(len(row), int) for row in back.F])
    assert len(igl.read_triangle_mesh(str(tmp_path / "again.obj"))[1]) == len(atlas.report.split.F)


def test_repairs_name_polygons() -> None:
    V, F = quads()
    turned = [*F.tolist()[:-1], F[-1, ::-1].tolist()]
    with pytest.warns(MeshWarning, match=rf"faces {len(F) - 1}\b.* are turned"):
        atlas = unwrap(V, turned, progress=False)
    assert (atlas.origin[flat(atlas.FTC)] == flat(turned)).all()
    a, b, c = atlas.flat[atlas.drawn.T]
    assert (np.linalg.det(np.stack((b - a, c - a), axis=-1)) > 0).all()  # pictures show no flipped face


def test_the_split_does_not_depend_on_the_scale_and_does_not_warn() -> None:
    V = np.array([[0, 0, 0], [2, 0, 0], [2, 2, 0], [1, 0.5, 0], [0, 2, 0.0]])
    faces = Polygons.from_faces([[0, 1, 2, 3, 4]])
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        local = faces.triangulate(V).F
        for scale in (1e-300, 1e-150, 1e150, 8e307):
            assert (local == faces.triangulate(V * scale).F).all()
        for broken in (np.nan, np.inf):
            V[2, 0] = broken
            assert faces.triangulate(V).F.shape == (3, 3)
            with pytest.raises(MeshError, match="vertices 2 are NaN or infinite"):
                unwrap(V, [[0, 1, 2, 3, 4]])


@pytest.mark.parametrize("sides", [3, 4])
def test_folds_of_the_map_are_seams(sides: int) -> None:
    """The map mirrors one half of a strip onto the other half."""
    columns = np.arange(-3.0, 4)
    V = np.array([[x, y, 0] for x in columns for y in (0.0, 1.0)])
    F = np.array([[2 * i, 2 * i + 2, 2 * i + 3, 2 * i + 1] for i in range(6)])
    if sides == 3:
        F = np.vstack((F[:, :3], F[:, [0, 2, 3]]))
    mirrored = np.abs(V[:, :2]) / 3
    assert texture_seams(F, F, V, mirrored).tolist() == [[6, 7]]
    mask = texture_seams(F, F, V, mirrored, sides=True)
    assert mask.sum() == 2
    assert len(unwrap(V, F, mask).charts) == 2
    # flat maps, faces of mixed orientation, and maps without area have no folds
    for map_ in (V[:, :2], -V[:, :2], mirrored * [[0, 1]]):
        assert len(texture_seams(F, F, V, map_)) == 0
    mixed = F.copy()
    mixed[::2] = mixed[::2, ::-1]
    assert texture_seams(mixed, mixed, V, mirrored).tolist() == [[6, 7]]
    assert len(texture_seams(mixed, mixed, V, V[:, :2])) == 0
    # a sliver that is flipped by single precision is not cut out
    rounded = V[:, :2] + [[1000, 0]]
    rounded[6] = (rounded[4] + rounded[8]) / 2 + [0, -4e-5]
    assert (
        len(texture_seams([[4, 6, 8], [4, 8, 9], [6, 4, 0]], [[4, 6, 8], [4, 8, 9], [6, 4, 0]], V, rounded))
        == 0
    )


def test_doubled_vertices_on_less_than_half_of_the_boundary_are_named_in_a_warning() -> None:
    V, F = igl.triangulated_grid(9, 9)
    V = np.column_stack((V, (V**2).sum(axis=1)))
    half = V[F].mean(axis=1)[:, 0] > 0.5
    rim = np.intersect1d(F[half], F[~half])
    twice, apart = np.vstack((V, V)), np.where(half[:, None], F + len(V), F)
    V2, _, _, F2 = igl.remove_duplicate_vertices(
        np.column_stack((twice, np.arange(len(twice)) // len(V))), apart, 0
    )[:4]
    said = rf"\({2 * len(rim)} in all\) of the boundary are doubled along edges.* weld=0 joins"
    with pytest.warns(MeshWarning, match=said):
        assert len(unwrap(V2[:, :3], F2, charts=ChartOptions(trade=0)).charts) == 2
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        assert len(unwrap(V2[:, :3], F2, weld=0).charts) == 1
        unwrap(V, F)
    assert not any("doubled" in str(warning.message) for warning in caught)
