"""Distance errors agree with computations that are independent of the library."""

from __future__ import annotations

import igl
import numpy as np
import pytest
from conftest import bumps, load

from igl_linabf import MeshError, flatten, quality
from igl_linabf.measures import Distances, distance_error
from igl_linabf.surface import Submesh


def grid(n: int) -> tuple[np.ndarray, np.ndarray]:
    V, F = igl.triangulated_grid(n, n)
    return np.insert(V, 2, 0.0, axis=1), F


def test_an_unrolled_cylinder_has_no_error_and_a_scaled_map_the_error_of_its_scale() -> None:
    flat, F = grid(12)
    angle = 3 * flat[:, 0]
    # roll the grid up to a cylinder, with chords as edges
    V = np.column_stack((np.cos(angle), np.sin(angle), 3 * flat[:, 1])) / 3
    # the error is not zero, because a chord is shorter than its arc
    assert distance_error(V, F, flat[:, :2]) < 0.01
    for scale in (0.5, 1.25):
        assert distance_error(flat, F, scale * flat[:, :2] + 7) == pytest.approx(abs(scale - 1), rel=1e-9)


def test_neighbours_are_within_the_rings_and_distances_are_shortest_paths() -> None:
    V, F = bumps(200)
    found = Distances.measure_within_rings(Submesh.from_input(V, F), 3)
    adjacent = igl.adjacency_matrix(F).toarray() > 0
    near = np.linalg.matrix_power(adjacent + np.eye(len(V)), 3) > 0
    np.fill_diagonal(near, False)
    assert set(map(tuple, found.ends.T.tolist())) == set(map(tuple, np.argwhere(near).tolist()))
    none = np.zeros(0, dtype=np.int64)
    for source in (0, 50, 199):  # compare with exact geodesics on the whole surface
        mine = found.ends[0] == source
        whole = igl.exact_geodesic(V, F, np.array([source]), none, found.ends[1][mine], none)
        assert (found.length[mine] >= whole - 1e-9).all()
        assert np.median(found.length[mine] / whole) == pytest.approx(1, abs=1e-9)


def test_a_sample_of_vertices_estimates_the_error_of_all_vertices(monkeypatch: pytest.MonkeyPatch) -> None:
    V, F = bumps(3000)
    uv = flatten(V, F, method="isometric").uv
    sampled = distance_error(V, F, uv, 3)
    monkeypatch.setattr("igl_linabf.measures.distances.MAX_SOURCES", 10_000)
    assert sampled == pytest.approx(distance_error(V, F, uv, 3), abs=0.003)


def test_fitting_lengths_gives_the_scale_with_the_least_error(monkeypatch: pytest.MonkeyPatch) -> None:
    V, F = bumps(400)
    by_area = flatten(V, F, method="isometric").uv
    few = distance_error(V, F, flatten(V, F, method="isometric", fit="lengths").uv)
    monkeypatch.setattr("igl_linabf.flattening.functions.FIT_SOURCES", 10_000)
    uv = flatten(V, F, method="isometric", fit="lengths").uv
    least = distance_error(V, F, uv)
    assert all(distance_error(V, F, scale * uv) > least for scale in (0.98, 0.999, 1.001, 1.02))
    assert distance_error(V, F, by_area) >= least
    assert least <= few < least + 1e-3
    assert np.ptp(uv / by_area) < 1e-6 * abs(uv / by_area).max()  # the two maps differ only by a scale


def test_quality_measures_distances_on_request() -> None:
    V, F = load("bumps")
    uv = flatten(V, F).uv
    assert quality(V, F, uv).distance_error is None
    assert "distance error" not in str(quality(V, F, uv))
    asked = quality(V, F, uv, rings=2)
    assert asked.distance_error == distance_error(V, F, uv, 2)
    assert f"{asked.distance_error:.4g}" in str(asked)


def test_invalid_arguments_of_distances_are_refused() -> None:
    V, F = load("bumps")
    uv = flatten(V, F).uv
    for rings in (0, 1.5, "7", None):
        with pytest.raises(ValueError, match="use an integer from 1 on"):
            distance_error(V, F, uv, rings)
    with pytest.raises(MeshError, match="are the same triangle"):
        distance_error(V, np.vstack((F, F[:1])), uv)
    with pytest.raises(ValueError, match="fit is 'length'"):
        flatten(V, F, fit="length")
    with pytest.raises(ValueError, match="pins set the scale"):
        flatten(V, F, [0, 1], [[0, 0], [1, 0]], method="linabf", fit="lengths")
