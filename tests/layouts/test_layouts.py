"""Layouts compute a map from the angles of its triangles."""

from __future__ import annotations

import igl
import numpy as np
import pytest
from conftest import DISKS, best_fit_distance, load

from igl_linabf import LinABF, MeshError, flatten, linabf
from igl_linabf.flattening import linabf_angles
from igl_linabf.layouts import layout
from igl_linabf.layouts.conformal_energy import find_far_points

METHODS = ("boundary", "least-squares", "greedy")


@pytest.mark.parametrize("name", ["bumps", "cortex", *DISKS])
def test_all_layouts_agree_on_consistent_angles(name: str) -> None:
    V, F = load(name)
    angles = linabf_angles(V, F, iterations=12, tol=1e-12)
    maps = [layout(F, angles, method=method) for method in METHODS]
    # greedy layout accumulates rounding errors along its longest path, relative to the smallest triangle
    for uv, tolerance in zip(maps[1:], (1e-6, 1e-5), strict=True):
        assert best_fit_distance(uv, maps[0]) <= tolerance
    assert np.allclose(layout(F, angles), maps[0])


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("name", ["bumps", "flat2d__common3d_alligator.obj"])
def test_every_layout_reproduces_a_flat_mesh(name: str, method: str) -> None:
    V, F = load(name)
    flat = V * [1, 1, 0]
    result = flatten(flat, F, method=LinABF(layout=method))
    assert best_fit_distance(result.uv, flat[:, :2]) <= 1e-6
    assert result.outcome.value == "converged"
    assert result.report.iterations == 0
    corners = V[:, :2][F[0]], result.uv[F[0]]
    lengths = [np.linalg.norm(c - np.roll(c, 1, axis=0), axis=1) for c in corners]
    assert np.allclose(*lengths, rtol=1e-6)  # the map has the units of the mesh


def test_map_without_pins_has_the_area_of_the_surface_and_lies_centred() -> None:
    V, F = load("cortex")
    uv = linabf(V, F)
    area = igl.doublearea(uv, F) / 2
    assert np.isclose(area.sum(), igl.doublearea(V, F).sum() / 2)
    assert np.abs(area @ uv[F].mean(axis=1)).max() <= 1e-9 * area.sum() * np.ptp(uv)
    assert np.isclose(igl.doublearea(layout(F, linabf_angles(V, F)), F).sum() / 2, 1)


@pytest.mark.parametrize("name", ["bumps", "cortex"])
@pytest.mark.parametrize("method", METHODS)
def test_map_without_pins_has_its_principal_axes_along_x_and_y(name: str, method: str) -> None:
    V, F = load(name)
    uv = linabf(V, F, layout=method)
    xx, xy, yy = second_moments(uv, F)
    assert abs(xy) <= 1e-9 * (xx + yy)
    assert xx >= yy
    # the third moment of the triangle centres along x is positive
    assert igl.doublearea(uv, F) @ uv[F].mean(axis=1)[:, 0] ** 3 > 0


def second_moments(uv: np.ndarray, F: np.ndarray) -> tuple[float, float, float]:
    """Return the integrals of x x, x y and y y over the map, exact by the midpoint rule for triangles."""
    middle = (uv[F] + uv[np.roll(F, 1, axis=1)]) / 2
    weight = np.abs(igl.doublearea(uv, F)) / 6
    xx, xy, yy = (
        float((weight[:, None] * middle[..., i] * middle[..., j]).sum()) for i, j in ((0, 0), (0, 1), (1, 1))
    )
    return xx, xy, yy


@pytest.mark.parametrize("name", ["bumps", "cortex"])
def test_default_pins_of_the_least_squares_layout_are_half_the_loop_apart_and_far(name: str) -> None:
    V, F = load(name)
    points = V[igl.boundary_loop(F)]
    length = np.linalg.norm(np.roll(points, -1, axis=0) - points, axis=1)
    arc = np.cumsum(length) - length
    i, j = find_far_points(points)
    apart = abs(arc[i] - arc[j])
    assert abs(apart / length.sum() - 0.5) <= length.max() / length.sum()
    # no other pins half a loop apart are farther from each other, up to the length of an edge
    around = np.abs(arc[:, None] - arc)
    half = np.abs(around - length.sum() / 2) <= length.min() / 2
    distance = np.linalg.norm(points[:, None] - points, axis=2)
    assert np.linalg.norm(points[i] - points[j]) >= distance[half].max() - length.max()


def test_every_layout_meets_two_pins_and_keeps_its_shape() -> None:
    V, F = load("bumps")
    b, bc = [5, 300], [[1.0, 2.0], [3.0, -1.0]]
    angles = linabf_angles(V, F, iterations=12)
    free = {method: layout(F, angles, method=method) for method in METHODS}
    for method in METHODS:
        uv = layout(F, angles, b, bc, method=method)
        assert np.abs(uv[b] - bc).max() <= 1e-12
        assert best_fit_distance(uv, free[method]) <= 1e-6


def test_pins_matter_little_after_one_step_and_not_after_convergence() -> None:
    V, F = load("cortex")
    loop = igl.boundary_loop(F)
    for iterations, bound in ((1, 5e-2), (12, 1e-8)):
        angles = linabf_angles(V, F, iterations=iterations)
        default = layout(F, angles, method="least-squares")
        for i, j in ((0, 40), (10, 150), (100, 101)):
            other = layout(F, angles, [loop[i], loop[j]], [[0, 0], [1, 0]], method="least-squares")
            assert best_fit_distance(other, default) <= bound


@pytest.mark.parametrize("name", ["ball", "disk__igl_camel_b.obj"])
def test_auto_uses_the_boundary_layout_only_where_the_boundary_closes(name: str) -> None:
    V, F = load(name)
    one = flatten(V, F, method=LinABF(iterations=1))
    assert one.report.gap > 1e-2
    assert one.report.layout == "least-squares"
    both = flatten(V, F)
    assert both.report.gap < 2.5e-3
    assert both.report.layout == "boundary"


@pytest.mark.parametrize(
    ("spoil", "says"),
    [
        (lambda a: a[:-1], "rows for"),
        (lambda a: a * 1.01, "not those of a triangle"),
        (lambda a: a * (1 + 1e-5), "not those of a triangle"),
        (lambda a: a * [1, -1, 1], "not those of a triangle"),
        (lambda a: np.where(np.arange(a.size).reshape(a.shape) == 4, np.nan, a), "faces 1 "),
        (lambda a: a[:, :2], "shape"),
    ],
)
def test_angles_that_form_no_triangles_are_refused(spoil, says: str) -> None:
    _, F = load("bumps")
    V, _ = load("bumps")
    with pytest.raises(MeshError, match=says):
        layout(F, spoil(igl.internal_angles(V, F)))


def test_angles_that_sum_to_pi_up_to_rounding_are_accepted() -> None:
    V, F = load("bumps")
    angles = linabf_angles(V, F)
    assert best_fit_distance(layout(F, angles * (1 + 1e-8)), layout(F, angles)) <= 1e-6


def test_one_or_two_triangles_keep_their_edge_lengths() -> None:
    V = np.array([[0.0, 0, 0], [3, 0, 0], [0, 4, 0], [3, 4, 5]])
    for F in ([[0, 1, 2]], [[0, 1, 2], [2, 1, 3]]):
        F = np.array(F)
        for method in METHODS:
            used = len(np.unique(F))
            uv = linabf(V[:used], F, layout=method)
            assert np.allclose(igl.edge_lengths(uv, F), igl.edge_lengths(V[:used], F), rtol=1e-9)
