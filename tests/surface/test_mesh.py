"""Defects of a mesh are rejected with their place, and the outer loop encloses all other loops."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from bad_input import REFUSED
from holed_surfaces import surface

from igl_linabf import MeshError
from igl_linabf.surface import Submesh, planar_mesh, validate_pins


@pytest.mark.filterwarnings("ignore:vertices 12 belong to no face")
@pytest.mark.parametrize("name", REFUSED)
def test_each_defect_is_rejected_with_its_location(name: str) -> None:
    V, F, pinned, says = REFUSED[name]
    with pytest.raises(MeshError, match=says) as caught:
        mesh = planar_mesh(V, F)
        validate_pins(*(pinned or (None, None)), mesh.vertices, mesh.n_given)
    assert ": " in str(caught.value)  # a remedy follows the colon


def make_concentric_circles(radii: list[float], around: list[int]) -> tuple[np.ndarray, np.ndarray]:
    """Return triangles between concentric circles with the given radii and numbers of vertices."""
    V = [r * np.exp(2j * np.pi * np.arange(n) / n) for r, n in zip(radii, around, strict=True)]
    F, first = [], 0
    for n, m in pairwise(around):
        i, j = 0, 0
        while i < n or j < m:
            a, b = first + i % n, first + n + j % m
            if j == m or (i < n and (i + 1) * m <= (j + 1) * n):
                F.append([b, first + (i + 1) % n, a])
                i += 1
            else:
                F.append([a, b, first + n + (j + 1) % m])
                j += 1
        first += n
    z = np.concatenate(V)
    return np.column_stack((z.real, z.imag, 0 * z.real)), np.array(F)


@pytest.mark.parametrize("around", [[40, 20, 12], [12, 20, 40], [12, 12, 12]])
def test_the_outer_loop_is_the_longest_regardless_of_its_number_of_edges(around: list[int]) -> None:
    V, F = make_concentric_circles([1.0, 2.0, 3.0], around)
    for scale in (1.0, 1e-3):
        outer, hole = planar_mesh(scale * V, F).topology.loops
        np.testing.assert_allclose(np.linalg.norm(V[outer], axis=1), 3)
        np.testing.assert_allclose(np.linalg.norm(V[hole], axis=1), 1)
    asked = planar_mesh(V, F, outer=3).topology.loops
    assert 3 in asked[0] and len(asked) == 2


@pytest.mark.parametrize("name", ["comb", "slot"])
@pytest.mark.parametrize("shape", ["flat", "rolled up", "bumpy", "bowl"])
def test_the_outer_loop_is_the_rim_even_if_a_window_has_the_longer_edge(name: str, shape: str) -> None:
    V, F = surface(name)
    (x, y, _), is_rim = V.T, (V[:, :2] == 0).any(axis=1) | (V[:, :2] == 10).any(axis=1)
    space = {
        "flat": V,
        "rolled up": np.column_stack((2 * np.cos(x / 2), y, 2 * np.sin(x / 2))),
        "bumpy": V + np.outer(np.random.default_rng(0).normal(0, 0.1, len(V)), [0, 0, 1]),
        "bowl": np.column_stack((x, y, -(np.hypot(x - 5, y - 5) ** 2) / 6)),
    }[shape]
    rim, window = planar_mesh(space, F).topology.loops
    assert is_rim[rim].all() and not is_rim[window].any()


@pytest.mark.parametrize("height", [0.0, 1e-11, 1e-9, 1e-6])
@pytest.mark.parametrize("centre", [0.0, 1e3, 1e6])
def test_an_area_within_the_rounding_error_counts_as_zero(height: float, centre: float) -> None:
    turn = np.linalg.qr(np.random.default_rng(0).normal(size=(3, 3)))[0]
    V = np.array([[0, 0, 0], [1, 0, 0], [0.4, height, 0]]) @ turn + centre
    rounding = 2 * np.finfo(float).eps * max(1.0, centre)  # rounding error of the coordinates
    if height < rounding:
        with pytest.raises(MeshError, match=r"faces 0 have zero area \(face 0 has vertices \[0, 1, 2\]\)"):
            planar_mesh(V, [[0, 1, 2]])
    elif height > 10 * rounding:
        double_area = Submesh.from_input(V, [[0, 1, 2]]).areas_and_products[0]
        assert double_area[0] == pytest.approx(height, abs=10 * rounding)
