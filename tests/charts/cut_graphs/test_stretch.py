"""Estimate of the stretch of a map along given seams, from which seams are chosen."""

from __future__ import annotations

from collections.abc import Callable

import igl
import numpy as np
import pytest
from conftest import bumps, load
from scipy.ndimage import zoom

from igl_linabf import cut, find_seams, flatten, quality, unwrap
from igl_linabf.charts.cut_graphs import ISOMETRIC_STRETCH_WEIGHT
from igl_linabf.charts.cut_graphs.closed_surface import ClosedSurface
from igl_linabf.charts.cut_graphs.stretch import predict_stretch
from igl_linabf.charts.seams.growth import estimate_branch_gains
from igl_linabf.surface import Submesh


def torus(n: int = 60, m: int = 24) -> tuple[np.ndarray, np.ndarray]:
    """Return a torus cut open along two circles."""
    u, v = (x.ravel() for x in np.meshgrid(np.arange(n + 1) / n, np.arange(m + 1) / m, indexing="ij"))
    grid = igl.triangulated_grid(m + 1, n + 1)[1]
    a, b = 2 * np.pi * u, 2 * np.pi * v
    r = 3 + np.cos(b)
    return np.column_stack((r * np.cos(a), r * np.sin(a), np.sin(b))), grid


def cap() -> tuple[np.ndarray, np.ndarray]:
    """Return a third of a sphere."""
    V, F = igl.upsample(*igl.icosahedron(), 4)
    V /= np.linalg.norm(V, axis=1)[:, None]
    return igl.remove_unreferenced(V, F[V[F].mean(axis=1)[:, 2] > 1 / 3])[:2]


@pytest.mark.parametrize("surface", [cap, torus, bumps])
def test_expected_stretch_is_the_stretch_of_the_isometric_map(
    surface: Callable[[], tuple[np.ndarray, np.ndarray]],
) -> None:
    V, F = surface()
    whole = ClosedSurface.from_submesh(Submesh.manifold_from_input(V, F), isometric=True)
    stretch, _ = predict_stretch(whole, np.arange(whole.graph.n_holes))
    made = quality(V, F, flatten(V, F, method="isometric").uv).stretch_l2 - 1
    assert 0.65 < (stretch - 1) / ISOMETRIC_STRETCH_WEIGHT / made < 1.5


@pytest.mark.filterwarnings("ignore:.* edges are cut in addition to the given seams")
@pytest.mark.parametrize("name", ["closed__igl_cow.off", "handles__bff_punctured-torus.obj", "pial"])
def test_seams_for_the_isometric_method_lower_the_cost_of_its_map(name: str) -> None:
    V, F = load(name)
    size = np.sqrt(igl.doublearea(V, F).sum() / 2)

    def cost(method: str) -> float:
        """Return the cost of the isometric map along the seams that are found for a method."""
        seams = find_seams(V, F, method=method)
        atlas = unwrap(V, F, seams, method="isometric")
        length = np.linalg.norm(V[seams[:, 0]] - V[seams[:, 1]], axis=1).sum() / size
        return ISOMETRIC_STRETCH_WEIGHT * (atlas.quality.stretch_l2 - 1) + length / 6

    assert cost("isometric") < cost("linabf") * 1.02
    F_cut = cut(V, F, find_seams(V, F, method="isometric"))[1]
    assert len(igl.boundary_loop_all(F_cut)) == 1


def bumpy_square(n: int = 22) -> tuple[np.ndarray, np.ndarray]:
    """Return a square with bumps as high as a sixth of its side."""
    x, y = (p.ravel() for p in np.meshgrid(*[np.linspace(0, 1, n)] * 2, indexing="ij"))
    height = np.random.default_rng(3).standard_normal((6, 6))
    z = 0.09 * zoom(height, n / 6, order=3).ravel()
    return np.column_stack((x, y, z)), igl.triangulated_grid(n, n)[1]


def test_a_leaf_of_an_isometric_seam_saves_much_for_its_length() -> None:
    closed = ClosedSurface.from_submesh(Submesh.manifold_from_input(*bumpy_square()), isometric=True)
    boundary = np.array([0])
    far, before, _ = closed.graph.find_shortest_paths(boundary)
    whole, scale = predict_stretch(closed, boundary)

    def saved(leaf: int) -> float:
        """Return how much a seam to a node reduces the stretch, divided by the length of the seam."""
        way = closed.graph.find_edges_on_paths(before, [leaf])
        return (whole - predict_stretch(closed, closed.graph.find_boundary_nodes(way))[0]) / far[leaf]

    every = np.array([saved(leaf) for leaf in range(1, closed.graph.n)])
    taken = int(np.argmax(estimate_branch_gains(closed, boundary, scale, far)))
    assert every[taken - 1] > np.quantile(every, 0.9)
    assert every[taken - 1] > 0.5 * every.max()
