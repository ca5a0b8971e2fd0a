"""The grid of iso-lines covers the surface, and its cells are quadrangles with right angles."""

from __future__ import annotations

import igl
import numpy as np
import pytest
from conftest import load

from igl_linabf import MeshError, linabf, unwrap
from igl_linabf.io import write_grid
from igl_linabf.remesh import QuadGrid, quad_grid
from igl_linabf.surface import complex_positions


def holes() -> tuple[np.ndarray, np.ndarray]:
    from holes import crown_without_tips

    return crown_without_tips()


SURFACES = {
    "bumps": lambda: load("bumps"),
    "cortex": lambda: load("cortex"),
    "holes": holes,
    "beetle": lambda: load("holes__igl_beetle.off"),
    "camelhead": lambda: load("disk__igl_camelhead.off"),
}


@pytest.fixture(scope="module", params=SURFACES)
def surface(request) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    V, F = SURFACES[request.param]()
    return V, F, linabf(V, F)


def plate(n: int) -> tuple[np.ndarray, np.ndarray]:
    """Return a flat square of n by n unit squares, each split into two triangles."""
    x, y = np.meshgrid(np.arange(n + 1.0), np.arange(n + 1.0), indexing="ij")
    i = np.arange((n + 1) ** 2).reshape(n + 1, n + 1)
    a, b, c, d = i[:-1, :-1].ravel(), i[1:, :-1].ravel(), i[1:, 1:].ravel(), i[:-1, 1:].ravel()
    F = np.concatenate((np.column_stack((a, b, c)), np.column_stack((a, c, d))))
    return np.column_stack((x.ravel(), y.ravel(), np.zeros((n + 1) ** 2))), F


def half_edges(grid: QuadGrid) -> np.ndarray:
    return np.concatenate([np.column_stack((face, np.roll(face, -1))) for face in grid.faces])


def area(points: np.ndarray) -> float:
    """Return the area of a polygon in space, half the length of the sum of its cross products."""
    return float(np.linalg.norm(np.cross(points, np.roll(points, -1, axis=0)).sum(axis=0)) / 2)


def corner_angles(grid: QuadGrid) -> np.ndarray:
    corners = grid.V[grid.quads]
    ahead, back = np.roll(corners, -1, axis=1) - corners, np.roll(corners, 1, axis=1) - corners
    cosine = (ahead * back).sum(axis=2)
    return np.degrees(np.arccos(cosine / np.linalg.norm(ahead, axis=2) / np.linalg.norm(back, axis=2)))


@pytest.mark.parametrize("cells", [8, 1000, pytest.param(5000, marks=pytest.mark.slow)])
def test_the_grid_is_a_manifold_with_the_topology_of_the_surface(surface, cells) -> None:
    V, F, uv = surface
    grid = quad_grid(V, F, uv, np.sqrt(igl.doublearea(uv, F).sum() / 2 / cells))
    sides = half_edges(grid)
    assert len(np.unique(sides, axis=0)) == len(sides)  # each directed side occurs at most once
    edges, count = np.unique(np.sort(sides, axis=1), axis=0, return_counts=True)
    assert (np.unique(sides) == np.arange(len(grid.V))).all()
    assert len(grid.V) - len(edges) + len(grid.faces) == igl.euler_characteristic(F)
    rim = edges[count == 1]
    tails, links = np.unique(rim, return_counts=True)
    assert (links == 2).all()
    # in the map, the boundary of the grid is as long as the boundary of the surface
    around = igl.boundary_facets(F)[0]
    length = np.linalg.norm(uv[around[:, 0]] - uv[around[:, 1]], axis=1).sum()
    assert np.isclose(np.linalg.norm(grid.uv[rim[:, 0]] - grid.uv[rim[:, 1]], axis=1).sum(), length)
    assert len(tails) >= 3


def test_the_cells_cover_the_map_once_and_quads_dominate(surface) -> None:
    V, F, uv = surface
    grid = quad_grid(V, F, uv)
    signed = [0.0] * len(grid.faces)
    for i, face in enumerate(grid.faces):
        z = complex_positions(grid.uv[face])
        signed[i] = float((z.conj() * np.roll(z, -1)).imag.sum() / 2)
    assert min(signed) > -1e-9 * grid.spacing**2
    assert np.isclose(sum(signed), igl.doublearea(uv, F).sum() / 2)
    assert np.allclose(np.array(signed)[grid.whole], grid.spacing**2)
    assert 900 < len(grid.faces) < 1250
    assert len(grid.quads) == grid.whole.sum() > 0.7 * len(grid.faces)
    # the corners of complete cells lie on neighbouring iso-lines
    corners = grid.uv[grid.quads] / grid.spacing
    assert np.allclose(corners, np.round(corners))
    assert np.allclose(np.ptp(corners, axis=1), 1)


def test_vertices_are_on_the_surface_where_the_map_says(surface) -> None:
    V, F, uv = surface
    grid = quad_grid(V, F, uv)
    flat = np.insert(uv, 2, 0, axis=1)
    squared, face, nearest = igl.point_mesh_squared_distance(np.insert(grid.uv, 2, 0, axis=1), flat, F)
    assert squared.max() < (1e-9 * np.ptp(uv)) ** 2
    corners = [np.ascontiguousarray(flat[F[face, k]]) for k in range(3)]
    weights = igl.barycentric_coordinates(nearest, *corners)
    there = np.einsum("pk,pkx->px", weights, V[F[face]])
    away = np.linalg.norm(there - grid.V, axis=1) / np.linalg.norm(np.ptp(V, axis=0))
    assert away.max() < 1e-6


def test_on_a_flat_mesh_the_cells_are_squares() -> None:
    V, F = plate(12)
    turn = np.array([[0.8, 0.6, 0], [-0.6, 0.8, 0], [0, 0, 1.0]])
    for spacing, cells in ((1.0, 144), (3.0, 16), (0.75, 256)):
        grid = quad_grid(V @ turn, F, V[:, :2], spacing)
        assert len(grid.faces) == len(grid.quads) == cells
        assert np.allclose(corner_angles(grid), 90)
        assert np.isclose(sum(area(grid.V[face]) for face in grid.faces), 144)
    shifted = quad_grid(V, F, V[:, :2] + [0.5, 0.25], 1.0)  # no iso-line runs through a vertex
    assert len(shifted.faces) == 13 * 13
    assert len(shifted.quads) == 11 * 11
    assert {len(face) for face in shifted.faces} == {4}
    assert np.isclose(sum(area(shifted.V[face]) for face in shifted.faces), 144)


def test_area_and_angles_converge() -> None:
    V, F = load("bumps")
    uv = linabf(V, F)
    total, off, missing = igl.doublearea(V, F).sum() / 2, [], []
    for cells in (500, 2000, 8000):
        grid = quad_grid(V, F, uv, np.sqrt(igl.doublearea(uv, F).sum() / 2 / cells))
        missing.append(abs(sum(area(grid.V[face]) for face in grid.faces) / total - 1))
        off.append(np.abs(corner_angles(grid) - 90).mean())
    assert missing[0] > missing[1] > missing[2]
    assert missing[2] < 0.01
    assert max(off) < 2
    assert abs(corner_angles(grid).mean() - 90) < 0.2


def test_overlapping_maps_and_atlases_are_supported() -> None:
    V, F = plate(8)
    spiral = complex_positions(V[:, :2]) + 3
    wound = np.exp((spiral - 7) * 0.9j)  # a map that winds almost one and a half times around the origin
    uv = np.column_stack((wound.real, wound.imag))
    assert (igl.doublearea(uv, F) > 0).all()
    grid = quad_grid(V, F, uv, 0.2 * np.ptp(uv))
    assert np.isclose(sum(area(grid.V[face]) for face in grid.faces), 64, rtol=0.2)
    V, F = igl.upsample(*igl.icosahedron(), 3)
    atlas = unwrap(V, F)
    grid = quad_grid(V[atlas.origin], atlas.FTC, atlas.TC, 0.02)
    assert len(grid.quads) > 0.7 * len(grid.faces)
    assert np.allclose(np.linalg.norm(grid.V, axis=1), np.linalg.norm(V, axis=1).mean(), rtol=0.2)


def test_several_holes_in_one_cell_are_cut_apart() -> None:
    V, F = plate(9)
    middle = V[F].mean(axis=1)[:, :2]
    punched = F[~((np.floor(middle) % 3 == 1).all(axis=1))]  # a plate with nine square holes
    assert igl.euler_characteristic(punched) == 1 - 9
    grid = quad_grid(V, punched, V[:, :2], 100.0)
    sides = half_edges(grid)
    edges = np.unique(np.sort(sides, axis=1), axis=0)
    assert len(grid.V) - len(edges) + len(grid.faces) == 1 - 9
    assert np.isclose(sum(area(grid.V[face]) for face in grid.faces), 81 - 9)


def test_each_cell_with_a_hole_is_cut_in_two() -> None:
    V, F = plate(12)
    middle = np.floor(V[F].mean(axis=1)[:, :2])
    # four holes; the cuts through the middle of the holes meet no vertices
    punched = F[~(middle % 6 == 2).all(axis=1)]
    grid = quad_grid(V, punched, V[:, :2], 6.0)
    assert sorted(area(grid.V[face]) for face in grid.faces) == pytest.approx([14.5] * 4 + [20.5] * 4)


def test_corners_of_the_boundary_in_the_map_are_kept() -> None:
    V, F = plate(6)
    square = V[:, :2] - 3
    round_ = square * (np.abs(square).max(axis=1) / np.maximum(np.linalg.norm(square, axis=1), 1))[:, None]
    grid = quad_grid(V, F, round_, 20.0)  # four cells that meet in the centre
    assert len(grid.faces) == 4
    rim = igl.boundary_facets(F)[0]
    assert {tuple(p) for p in grid.uv.tolist()} >= {tuple(p) for p in round_[rim].reshape(-1, 2).tolist()}


def test_vertices_near_a_line_are_snapped_to_it() -> None:
    V, F = plate(6)
    uv = V[:, :2] + np.random.default_rng(0).uniform(-1e-11, 1e-11, (len(V), 2))
    grid = quad_grid(V, F, uv, 1.0)
    assert len(grid.faces) == len(grid.quads) == 36
    assert len(grid.V) == 49


def test_lines_across_a_thin_strip_are_counted() -> None:
    """The strip has little area but crosses too many lines."""
    V, F = plate(1)
    thin = V * [1e8, 1e-3, 1]
    with pytest.raises(MeshError, match="cells: give more"):
        quad_grid(V, F, thin[:, :2], 1.0)


def test_written_polygons_can_be_read_back(tmp_path) -> None:
    V, F = load("bumps")
    grid = quad_grid(V, F, linabf(V, F))
    path = tmp_path / "grid.obj"
    write_grid(path, grid)
    lines = [line.split() for line in path.read_text().splitlines()]
    vertices, flat = (
        np.array([line[1:] for line in lines if line[0] == k], dtype=float) for k in ("v", "vt")
    )
    assert np.array_equal(vertices, grid.V)
    assert np.array_equal(flat, grid.uv)
    faces = [[corner.split("/") for corner in line[1:]] for line in lines if line[0] == "f"]
    for written, face in zip(faces, grid.faces, strict=True):
        assert [(int(v) - 1, int(t) - 1) for v, t in written] == [(i, i) for i in face.tolist()]
    with pytest.raises(OSError, match="nowhere"):
        write_grid(tmp_path / "nowhere" / "grid.obj", grid)
    assert sorted(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize(
    ("spoil", "spacing", "error", "message"),
    [
        (lambda uv: uv * [1, -1], None, MeshError, "flipped"),
        (lambda uv: uv, -1.0, ValueError, "positive"),
        (lambda uv: uv, np.nan, ValueError, "positive"),
        (lambda uv: uv, 1e-7, MeshError, "cells: give more"),
        (lambda uv: uv[1:], None, MeshError, "one row a vertex"),
    ],
)
def test_invalid_maps_and_spacings_are_refused(spoil, spacing, error, message) -> None:
    V, F = load("bumps")
    with pytest.raises(error, match=message):
        quad_grid(V, F, spoil(linabf(V, F)), spacing)


def test_a_map_that_winds_twice_around_a_vertex_is_refused() -> None:
    around = np.exp(2j * np.pi * np.arange(12) / 12)
    rim = np.column_stack((around.real, around.imag, np.zeros(12)))
    V, F = np.vstack((np.zeros(3), rim)), np.array([(0, i + 1, (i + 1) % 12 + 1) for i in range(12)])
    doubled = complex_positions(V[:, :2]) ** 2
    with pytest.raises(MeshError, match="winds more than once around vertices 0"):
        quad_grid(V, F, np.column_stack((doubled.real, doubled.imag)), 0.1)
