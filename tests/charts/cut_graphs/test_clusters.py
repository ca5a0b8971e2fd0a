"""Clusters of vertices preserve handles and holes, and do not make seams worse."""

from __future__ import annotations

from collections.abc import Callable

import igl
import numpy as np
import pytest
from conftest import load

from igl_linabf.charts import cut, find_seams, unwrap
from igl_linabf.charts.cut_graphs import clusters
from igl_linabf.charts.cut_graphs.closed_surface import ClosedSurface
from igl_linabf.charts.cut_graphs.clusters import Contraction, Levels, build_shortest_path_trees
from igl_linabf.charts.features import CreasedSurface
from igl_linabf.charts.seams.growth import compute_seam_cost, grow_seam
from igl_linabf.charts.seams.search import SeamSearch, _PanelSeams
from igl_linabf.flattening import LinABF
from igl_linabf.surface import Submesh, clean, complex_positions, signed_double_areas

NAMES = (
    "nut",
    "double_torus",
    "punctured_nut",
    "closed__igl_3holes.off",
    "closed__optcuts_horse_f10000.obj",
    "handles__bff_punctured-torus.obj",
    "holes__igl_beetle.off",
)


def surface(name: str) -> Submesh:
    return max(Submesh.manifold_from_input(*load(name)).split_components(), key=lambda part: len(part.F))


def subdivide_beyond_clusters(name: str) -> tuple[np.ndarray, np.ndarray]:
    """Return a mesh, subdivided until its seams are found on clusters of vertices."""
    V, F = load(name)
    while len(V) <= clusters.MAX_CLUSTERS:
        V, F = igl.upsample(V, F, 1)
    return V, F


@pytest.mark.parametrize("hops", [1, 2, 5])
@pytest.mark.parametrize("name", NAMES)
def test_clusters_keep_handles_holes_area_and_curvature(name: str, hops: int) -> None:
    piece = ClosedSurface.from_submesh(surface(name))
    coarse = Contraction.from_forest(piece, build_shortest_path_trees(piece, hops)).coarse
    assert coarse.graph.n < piece.graph.n / 2
    assert coarse.graph.n - len(coarse.graph.ends) + coarse.graph.n_faces == 2 - 2 * piece.graph.genus
    assert (coarse.graph.n_holes, coarse.graph.genus) == (piece.graph.n_holes, piece.graph.genus)
    assert np.isclose(coarse.area.sum(), piece.area.sum())
    assert np.isclose(coarse.curvature.sum(), piece.curvature.sum())


@pytest.mark.parametrize("hops", [1, 3])
@pytest.mark.parametrize("name", NAMES)
def test_lifting_a_seam_preserves_its_topology(name: str, hops: int) -> None:
    piece = ClosedSurface.from_submesh(surface(name))
    smaller = Contraction.from_forest(piece, build_shortest_path_trees(piece, hops))
    seam, leaves = grow_seam(smaller.coarse, 6.0, False)
    carried, drawn = smaller.lift_along_trees(seam), smaller.lift(seam, leaves)
    assert (
        smaller.coarse.graph.find_seam_topology(seam)
        == piece.graph.find_seam_topology(carried)
        == piece.graph.find_seam_topology(drawn)
    )
    assert piece.graph.find_seam_topology(carried)[2]
    assert piece.graph.measure_length(carried) <= smaller.coarse.graph.measure_length(seam) * (
        1 + 1e-9
    )  # shorter if paths within a cluster overlap
    assert piece.graph.measure_length(drawn) <= piece.graph.measure_length(carried) * (1 + 1e-9)
    assert set(smaller.roots[leaves][np.isin(leaves, smaller.coarse.graph.ends[seam])]) <= set(
        piece.graph.ends[drawn].ravel()
    )


def test_contraction_ends_at_more_holes_than_clusters() -> None:
    piece = ClosedSurface.from_submesh(surface("holes__igl_beetle.off"))
    levels = Levels.from_surface(piece, piece.graph.n_holes - 1)
    assert piece.graph.n_holes <= levels.coarse.graph.n < piece.graph.n
    assert levels.coarse.graph.n_holes == piece.graph.n_holes


def test_the_scale_of_clusters_approximates_that_of_their_nodes() -> None:
    piece = ClosedSurface.from_submesh(surface("closed__optcuts_horse_f10000.obj"))
    smaller = Contraction.from_forest(piece, build_shortest_path_trees(piece, 1))
    fixed = np.array([0])
    u = piece.laplacian.dirichlet_solver.solve(fixed, -piece.curvature)
    coarse = smaller.coarse.laplacian.dirichlet_solver.solve(smaller.label[fixed], -smaller.coarse.curvature)
    mean = np.bincount(smaller.label, u * piece.area) / smaller.coarse.area
    assert np.corrcoef(mean, coarse)[0, 1] >= 0.995


@pytest.mark.parametrize("name", ["double_torus", "closed__igl_cow.off"])
def test_seams_of_large_surfaces_do_not_depend_on_position_or_other_components(name: str) -> None:
    V, F = subdivide_beyond_clusters(name)
    found = find_seams(V, F)
    F_cut = cut(V, F, found)[1]
    assert igl.euler_characteristic(F_cut) == len(igl.boundary_loop_all(F_cut)) == 1
    # rotate by 180 degrees and scale by 4, both without rounding errors, because many paths have equal length
    moved = V * [-4, -4, 4]
    assert np.array_equal(find_seams(moved, F), found)
    small_V, small_F = igl.icosahedron()
    both = find_seams(np.concatenate((V, small_V + 2 * np.ptp(V))), np.concatenate((F, small_F + len(V))))
    assert np.array_equal(both[(both < len(V)).all(axis=1)], found)


@pytest.mark.parametrize("name", ["closed__optcuts_horse_f10000.obj", "handles__bff_punctured-torus.obj"])
def test_seams_found_on_clusters_cost_no_more_than_on_the_surface(name: str, monkeypatch) -> None:
    part = Submesh.manifold_from_input(*subdivide_beyond_clusters(name))
    piece, costs = ClosedSurface.from_submesh(part), []
    node = np.full(len(part.V), -1)
    node[piece.edges.ravel()] = piece.graph.ends.ravel()
    for most in (piece.graph.n, clusters.MAX_CLUSTERS):
        monkeypatch.setattr(clusters, "MAX_CLUSTERS", most)
        edges = SeamSearch(6.0, LinABF())._find_seam_of_component(
            CreasedSurface(part), False, _PanelSeams.make_empty(1), 0
        )
        costs.append(compute_seam_cost(piece, piece.graph.find_edges_between(*node[edges].T), 6.0))
    assert costs[1] <= 1.03 * costs[0]


def test_two_arcs_between_adjacent_vertices_stay_apart() -> None:
    """On a torus with a nearly square section, two arcs of the seam join adjacent vertices."""
    u, v = (
        a.ravel() for a in np.meshgrid(*(2 * np.pi * np.arange(n) / n for n in (110, 100)), indexing="ij")
    )
    c, s = (np.sign(f(v)) * np.abs(f(v)) ** 0.15 for f in (np.cos, np.sin))
    V = np.column_stack(((1 + 0.5 * c) * np.cos(u), (1 + 0.5 * c) * np.sin(u), 0.5 * s))
    i, j = np.divmod(np.arange(11_000), 100)
    a, b, c, d = (100 * ((i + k) % 110) + (j + m) % 100 for k, m in ((0, 0), (1, 0), (1, 1), (0, 1)))
    F = np.concatenate((np.column_stack((a, b, c)), np.column_stack((a, c, d))))
    F_cut = cut(V, F, find_seams(V, F))[1]
    assert igl.euler_characteristic(F_cut) == len(igl.boundary_loop_all(F_cut)) == 1


def level_set(
    function: Callable[..., np.ndarray], reach: float, points: int
) -> tuple[np.ndarray, np.ndarray]:
    """Return the largest component of the zero set of a function in a cube, with a boundary on its sides."""
    grid = np.stack(np.meshgrid(*3 * [np.linspace(-reach, reach, points)], indexing="ij"), axis=-1)
    # marching cubes needs points whose x varies fastest
    grid = np.ascontiguousarray(grid.reshape(-1, 3)[:, ::-1])
    V, F, *_ = igl.marching_cubes(function(*grid.T), grid, *3 * [points], 0.0)
    V, F, *_ = clean(V, F)
    body = max(Submesh.from_input(V, F).split_components(), key=lambda part: len(part.F))
    return body.V, body.F


def schwarz(x: np.ndarray, y: np.ndarray, z: np.ndarray) -> np.ndarray:
    """Return several cells of Schwarz's P surface, cut open by the cube."""
    return np.cos(x) + np.cos(y) + np.cos(z)


def drilled_plate(x: np.ndarray, y: np.ndarray, z: np.ndarray) -> np.ndarray:
    """Return values that are negative inside a plate with nine bores."""
    bores = (0.12 - np.hypot(x - a, y - b) for a in (-0.5, 0, 0.5) for b in (-0.45, 0.05, 0.5))
    return np.maximum.reduce([np.abs(x) - 0.9, np.abs(y) - 0.8, np.abs(z) - 0.13, *bores])


@pytest.mark.parametrize(
    ("body", "reach", "points", "handles"), [(schwarz, 6.0, 40, 5), (drilled_plate, 1.0, 68, 9)]
)
def test_large_bodies_with_many_handles_become_good_charts(
    body: Callable[..., np.ndarray], reach: float, points: int, handles: int
) -> None:
    V, F = level_set(body, reach, points)
    whole = Submesh.manifold_from_input(V, F)
    assert len(V) > clusters.MAX_CLUSTERS
    assert whole.topology.genus == handles
    assert bool(whole.topology.loops) == (body is schwarz)
    atlas = unwrap(V, F, strict=True, progress=False)
    assert atlas.good
    assert atlas.FTC.shape == F.shape
    assert (signed_double_areas(complex_positions(atlas.TC), atlas.FTC.T) > 0).all()
    parts = whole.cut_along(atlas.seams)
    assert len(parts) == len(atlas.charts)
    assert all(len(part.topology.loops) == 1 and not part.topology.genus for part in parts)
