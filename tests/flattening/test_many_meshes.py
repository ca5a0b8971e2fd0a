"""Many meshes at once: the same results as a loop of `flatten`, with a separate outcome for each mesh."""

from __future__ import annotations

import dataclasses
import re
import warnings

import bad_input
import igl
import numpy as np
import pytest
from conftest import bumps, tree_cut
from scipy.spatial import ConvexHull

import igl_linabf as il
from igl_linabf import ChartOptions
from igl_linabf.charts.cut_graphs.closed_surface import ClosedSurface
from igl_linabf.charts.seams.growth import compute_seam_cost
from igl_linabf.charts.seams.search import SeamSearch
from igl_linabf.surface import Ragged, Submesh

Surface = tuple[np.ndarray, np.ndarray]


def one_by_one(V: object, F: object, method: object = "linabf") -> il.flattening.Flattening | il.MeshError:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            return il.flatten(V, F, method=method)
        except il.MeshError as error:
            return error


def remove_interior_vertex(V: np.ndarray, F: np.ndarray) -> Surface:
    """Return the mesh without an interior vertex and the faces around it."""
    inside = np.setdiff1d(np.arange(len(V)), igl.boundary_loop(F))
    kept = F[~(inside[np.argmin(np.linalg.norm(V[inside, :2], axis=1))] == F).any(axis=1)]
    used, index = np.unique(kept, return_inverse=True)
    return V[used], index.reshape(-1, 3)


def make_varied_meshes() -> dict[str, Surface]:
    """Return disks with every outcome, and surfaces that are not disks, by name."""
    sphere, faces = igl.icosahedron()
    for _ in range(3):
        sphere, faces = igl.upsample(sphere, faces)
        sphere = sphere / np.linalg.norm(sphere, axis=1)[:, None]
    V, F = bumps(150)
    stretched = sphere * [1, 1, 6]
    made = {f"bumps {k}": bumps(60 + 40 * k, k, 0.1 * k) for k in range(8)}
    made["open"] = bumps(80, 0, 1.3)  # its boundary is still open after a step and a chord step
    made["flat"] = (V * [1, 1, 0], F)
    made["triangle"] = (np.eye(3), np.array([[0, 1, 2]]))
    made["square"] = (
        np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]),
        np.array([[0, 1, 2], [0, 2, 3]]),
    )
    made["fan"] = (np.vstack(([[0, 0, 1]], V[:8])), np.array([[0, i, i % 8 + 1] for i in range(1, 9)]))
    made["almost closed"] = (sphere, faces[1:])
    made["limb"] = tree_cut(stretched, faces, 2)
    made["folded"] = tree_cut(sphere * [0.1, 1, 3], faces, 3, seed=1)
    made["needles"] = (V * [1, 1e-7, 1], F)
    made["hole"] = remove_interior_vertex(V, F)
    made["closed"] = (sphere, faces)
    made["two"] = (np.vstack((V, V + 5)), np.vstack((F, F + len(V))))
    made["unused"] = (np.vstack((V, V[:1])), F)
    made["turned"] = (V, np.vstack((F[:5, ::-1], F[5:])))
    made["cap"] = (
        np.array([[0, 0, 0], [1, 0, 0], [0.5, 1e-8, 0], [0.5, 1, 0]]),
        np.array([[0, 1, 2], [0, 2, 3], [2, 1, 3]]),
    )
    return made


@pytest.mark.filterwarnings("ignore::igl_linabf.MeshWarning", "ignore::igl_linabf.FallbackWarning")
@pytest.mark.parametrize(
    "method", ["linabf", il.LinABF(guarantee="injective", solver="direct"), "abf"], ids=str
)
def test_many_meshes_have_the_results_of_a_loop(method: object) -> None:
    meshes = dict(reversed(make_varied_meshes().items()))  # start with the surfaces that are not disks
    together = il.flatten_many(list(meshes.values()), method=method, errors="return")
    assert len(together) == len(meshes)
    for (name, mesh), made in zip(meshes.items(), together, strict=True):
        alone = one_by_one(*mesh, method)
        if isinstance(alone, il.MeshError):
            assert type(made) is type(alone) and str(made) == str(alone), name
            continue
        assert isinstance(made, il.flattening.Flattening), name
        size = np.ptp(alone.uv[np.isfinite(alone.uv).all(axis=1)], axis=0).max()
        np.testing.assert_allclose(made.uv, alone.uv, rtol=0, atol=1e-10 * size, err_msg=name)
        np.testing.assert_allclose(made.angles, alone.angles, rtol=0, atol=1e-10, err_msg=name)
        tried, tried_alone = ([str(one) for one in result.report.attempts] for result in (made, alone))
        assert tried == tried_alone, name
        told, expected = (re.sub(r"residual \S+", "", result.message) for result in (made, alone))
        assert told == expected, name  # without the residuals, which may consist of rounding errors
        for part in ("outcome", "method"):
            assert getattr(made, part) == getattr(alone, part), (name, part)
        for part in ("layout", "solver", "layout_solver", "inner_steps"):
            assert getattr(made.report, part) == getattr(alone.report, part), (name, part)
        for part in ("before", "after"):
            found, right = getattr(made, part), getattr(alone, part)
            assert found.largest == pytest.approx(right.largest, rel=1e-6, abs=1e-12), (name, part)
        assert made.report.gap == pytest.approx(alone.report.gap, rel=1e-6, abs=1e-12), name
        np.testing.assert_array_equal(made.flipped, alone.flipped)
        np.testing.assert_array_equal(made.report.repaired, alone.report.repaired)
        assert made.seconds["total"] > 0 and made.seconds.keys() <= alone.seconds.keys()


@pytest.mark.filterwarnings("ignore::igl_linabf.MeshWarning")
def test_a_bad_mesh_gets_an_error_and_does_not_stop_other_meshes() -> None:
    good = bumps(80)
    bad = [(V, F) for V, F, *_ in bad_input.REFUSED.values()]
    made = il.flatten_many(
        [mesh for pair in bad for mesh in (good, pair)] + [None, (1,), good], errors="return"
    )
    for mesh, result in zip(bad, made[1::2], strict=False):
        expected = one_by_one(*mesh)
        assert isinstance(result, type(expected))
        if isinstance(expected, il.MeshError):
            assert str(result) == str(expected) and result.__traceback__ is None
    alone = il.flatten(*good)
    for result in [*made[: 2 * len(bad) : 2], made[-1]]:
        np.testing.assert_allclose(result.uv, alone.uv, rtol=0, atol=1e-10)
    assert all(isinstance(result, il.MeshError) for result in made[-3:-1])
    assert il.flatten_many([]) == []
    with pytest.raises(il.MeshError, match=r"^mesh 1: the mesh is closed"):
        il.flatten_many([good, igl.icosahedron()])
    with pytest.raises(ValueError, match=r"^errors is 'ignore': use 'raise' or 'return'"):
        il.flatten_many([good], errors="ignore")


def test_threads_change_no_bit(monkeypatch: pytest.MonkeyPatch) -> None:
    meshes = [bumps(60 + 7 * k, k, 0.3) for k in range(24)]
    thin = bumps(300)
    # meshes with slivers are solved together with other meshes in one system
    meshes[3] = meshes[20] = (thin[0] * [1, 0.02, 1], thin[1])
    monkeypatch.setattr("igl_linabf.flattening.many_meshes.FACES_PER_SYSTEM", 1000)
    made = []
    for threads in "1", "3":
        monkeypatch.setenv("OMP_NUM_THREADS", threads)
        made.append(il.flatten_many(meshes, errors="return"))
    for one, three in zip(*made, strict=True):
        np.testing.assert_array_equal(one.uv, three.uv)
        assert str(one).split("seconds")[0] == str(three).split("seconds")[0]


def test_the_rotation_of_a_symmetric_disk_does_not_depend_on_rounding_errors() -> None:
    cross = np.array([[0, 0, 0], [1, 0, 0], [0, 2, 0], [-1, 0, 0], [0, -2, 0.0]])
    square = cross / [1, 2, 1]
    F = np.array([[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 1]])
    rng = np.random.default_rng(0)
    for V in (cross, square):
        maps = [il.linabf(V * (1 + 1e-15 * rng.normal(size=V.shape)), F) for _ in range(10)]
        assert np.ptp(maps, axis=0).max() < 1e-12


def test_ragged_rows_are_reduced_independently() -> None:
    sizes = np.array([3, 0, 1, 40, 7, 0])
    rows, rng = Ragged.from_sizes(sizes), np.random.default_rng(0)
    values = rng.normal(size=sizes.sum())
    pieces = np.split(values, np.cumsum(sizes)[:-1])
    np.testing.assert_allclose(rows.sum(values), [piece.sum() for piece in pieces])
    np.testing.assert_array_equal(rows.max(values), [piece.max() if len(piece) else 0 for piece in pieces])
    np.testing.assert_array_equal(rows.cumsum(values), np.concatenate([np.cumsum(piece) for piece in pieces]))
    np.testing.assert_array_equal(rows.repeat(np.arange(6)), np.repeat(np.arange(6), sizes))
    turned = np.concatenate([np.roll(piece, -1) for piece in pieces])
    np.testing.assert_array_equal(values[rows.next_element], turned)


def place_side_by_side(bodies: list[Surface]) -> Surface:
    start = np.cumsum([0] + [len(V) for V, _ in bodies[:-1]])
    return (
        np.concatenate([V for V, _ in bodies]),
        np.concatenate([F + first for (_, F), first in zip(bodies, start, strict=True)]),
    )


def box(rng: np.random.Generator) -> Surface:
    V = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)]) * rng.uniform(0.5, 2, 3)
    quads = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    return V, np.array([t for a, b, c, d in quads for t in ([a, b, c], [a, c, d])])


def leaf(rng: np.random.Generator) -> Surface:
    V = np.array([[0, 0, 0], [1, -0.4, 0.1], [2, 0, 0], [1, 0.4, 0.1], [1, 0, 0.0]])
    return V + rng.normal(scale=0.03, size=V.shape), np.array([[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]])


def body(rng: np.random.Generator, holes: int) -> Surface:
    """Return a convex body of about 20 vertices, without `holes` faces that share no vertex."""
    points = rng.normal(size=(20, 3)) * rng.uniform(0.3, 2, 3)
    hull = ConvexHull(points)
    a, b, c = points[hull.simplices.T]
    inward = (np.cross(b - a, c - a) * (a - points.mean(axis=0))).sum(axis=1) < 0
    F = np.where(inward[:, None], hull.simplices[:, ::-1], hull.simplices)
    used, F = np.unique(F, return_inverse=True)
    F = F.reshape(-1, 3)
    gone: list[int] = []
    for t in rng.permutation(len(F)).tolist():
        if len(gone) < holes and not np.isin(F[t], F[gone]).any():
            gone.append(t)
    return points[used], np.delete(F, gone, axis=0)


def test_charts_of_many_pieces_equal_those_of_single_pieces() -> None:
    rng = np.random.default_rng(0)
    bodies = (
        [leaf(rng) for _ in range(60)] + [box(rng) for _ in range(30)] + [body(rng, k % 4) for k in range(12)]
    )
    V, F = place_side_by_side(bodies)
    atlas = il.unwrap(V, F, method="linabf")
    assert atlas.good and np.sort(np.concatenate([chart.faces for chart in atlas.charts])).tolist() == list(
        range(len(F))
    )
    assert len(il.overlaps(atlas.TC, atlas.FTC, between=True)) == 0
    for i, chart in enumerate(atlas.charts):
        corners, local = np.unique(atlas.FTC[atlas.chart == i], return_inverse=True)
        surface = V[atlas.origin[corners]], local.reshape(-1, 3)
        np.testing.assert_allclose(chart.result.uv, il.flatten(*surface).uv, rtol=0, atol=1e-10)
        alone, here = map(dataclasses.asdict, (il.quality(*surface, atlas.TC[corners]), chart.quality))
        assert alone.pop("report") == pytest.approx(here.pop("report"), rel=1e-9, abs=1e-12)
        assert alone.pop("distance_error") is here.pop("distance_error") is None
        assert here == pytest.approx(alone, rel=1e-9, abs=1e-12)
    # each box is cut to a net without distortion
    boxes = [atlas.charts[i].quality for i in np.unique(atlas.chart[240:600])]
    assert max(quality.stretch_l2 for quality in boxes) < 1 + 1e-9


def test_seams_of_many_small_bodies_cost_no_more_than_one_by_one() -> None:
    rng = np.random.default_rng(1)
    bodies = [body(rng, holes) for holes in (0, 1, 2, 3) for _ in range(8)]
    surface = Submesh.manifold_from_input(*place_side_by_side(bodies))
    search = SeamSearch(ChartOptions.trade, il.LinABF())
    together = search.find_seams(surface)
    ratio = []
    for component in surface.split_components():
        piece = ClosedSurface.from_submesh(component)
        edges = component.vertices[piece.edges]
        found = np.isin(np.sort(edges) @ [surface.n_given, 1], np.sort(together) @ [surface.n_given, 1])
        alone = search.find_seams(component)
        right = np.isin(np.sort(edges) @ [surface.n_given, 1], np.sort(alone) @ [surface.n_given, 1])
        cost, least = (
            compute_seam_cost(piece, np.flatnonzero(seam), ChartOptions.trade) for seam in (found, right)
        )
        ratio.append((1 + cost) / (1 + least))
    assert np.mean(ratio) < 1.005 and max(ratio) < 1.1
    pieces = surface.cut_along(together)
    assert len(pieces) == len(bodies)
    assert all(piece.topology.is_planar and len(piece.topology.loops) == 1 for piece in pieces)
