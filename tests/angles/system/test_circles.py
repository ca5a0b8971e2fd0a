"""Polygons inscribed in circles: angles from side lengths, and the prediction of their change."""

from __future__ import annotations

import numpy as np
import pytest

from igl_linabf.angles.system.circles import (
    compute_central_angles,
    compute_inscribed_sums,
    predict_sum_changes,
)


def make_inscribed_polygon(seed: int, largest: float) -> tuple[np.ndarray, np.ndarray]:
    """Return vertices on a circle, and the angles subtended by the sides; `largest` is the largest angle."""
    rng = np.random.default_rng(seed)
    others = rng.uniform(0.1, 1, 3 + seed)
    centre = np.insert(others / others.sum() * (2 * np.pi - largest), seed % (2 + seed), largest)
    return 3 * np.exp(1j * np.append(0, np.cumsum(centre)[:-1])), centre


def compute_log_ratios(z: np.ndarray) -> np.ndarray:
    """Return the logarithm of the ratio of the next side to the previous side at each vertex."""
    length = np.log(np.abs(np.roll(z, -1) - z))
    return length - np.roll(length, 1)


@pytest.mark.parametrize("seed", range(6))
# above pi, the centre is outside of the polygon
@pytest.mark.parametrize("largest", [1.5, 3.0, 3.3, 4.5, 6.0])
def test_the_angles_of_an_inscribed_polygon_follow_from_its_sides(seed: int, largest: float) -> None:
    z, centre = make_inscribed_polygon(seed, largest)
    np.testing.assert_allclose(compute_central_angles(compute_log_ratios(z)), centre, rtol=1e-9, atol=1e-9)
    inside = np.angle((np.roll(z, 1) - z) / (np.roll(z, -1) - z)) % (2 * np.pi)
    np.testing.assert_allclose(
        compute_inscribed_sums(compute_log_ratios(z), False), inside, rtol=1e-9, atol=1e-9
    )
    # the loop of a hole is clockwise, because the mesh lies to its left
    back = np.conj(z)
    outside = np.angle((np.roll(back, 1) - back) / (np.roll(back, -1) - back)) % (2 * np.pi)
    np.testing.assert_allclose(
        compute_inscribed_sums(compute_log_ratios(back), True), outside, rtol=1e-9, atol=1e-9
    )


def test_sides_that_form_no_polygon_get_arcs_proportional_to_their_lengths() -> None:
    length = np.array([1.0, 5.0, 1.5, 2.0])
    log = np.log(length)
    np.testing.assert_allclose(
        compute_central_angles(log - np.roll(log, 1)), 2 * np.pi * length / length.sum()
    )


@pytest.mark.parametrize("wave", [1, 2, 3, 7])
@pytest.mark.parametrize("hole", [False, True])
def test_the_predicted_change_of_the_sums_is_one_wave_of_the_scale(wave: int, hole: bool) -> None:
    """If the log scale is a wave of k periods, the residual is k - 1 times the wave (k + 1 at a hole)."""
    n = 200
    angle, side = 2 * np.pi * np.arange(n) / n, 2 * np.pi / n
    scale = 1e-3 * np.cos(wave * angle + 0.4)
    missing = (wave + 1 if hole else wave - 1) * scale * side
    more = predict_sum_changes(np.zeros(n), (-side if hole else side) + missing, hole)
    expected = (-1 if hole else wave > 1) * scale * side
    np.testing.assert_allclose(more, expected, atol=1e-12)
