"""Polygons in circles: their angles follow from their sides, and what these will be from what is missing."""

from __future__ import annotations

import numpy as np
import pytest

from igl_linabf.angles.system.circles import central_angles, inscribed_sums, predict_change


def inscribed(seed: int, largest: float) -> tuple[np.ndarray, np.ndarray]:
    """Vertices on a circle; the angles at which the centre sees the sides, of which one is the largest."""
    rng = np.random.default_rng(seed)
    others = rng.uniform(0.1, 1, 3 + seed)
    centre = np.insert(others / others.sum() * (2 * np.pi - largest), seed % (2 + seed), largest)
    return 3 * np.exp(1j * np.append(0, np.cumsum(centre)[:-1])), centre


def ratios(z: np.ndarray) -> np.ndarray:
    """At each vertex: the logarithm of the next side over the last one."""
    length = np.log(np.abs(np.roll(z, -1) - z))
    return length - np.roll(length, 1)


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("largest", [1.5, 3.0, 3.3, 4.5, 6.0])  # from pi on, the centre is beyond that side
def test_the_angles_of_an_inscribed_polygon_follow_from_its_sides(seed: int, largest: float) -> None:
    z, centre = inscribed(seed, largest)
    np.testing.assert_allclose(central_angles(ratios(z)), centre, rtol=1e-9, atol=1e-9)
    inside = np.angle((np.roll(z, 1) - z) / (np.roll(z, -1) - z)) % (2 * np.pi)
    np.testing.assert_allclose(inscribed_sums(ratios(z), False), inside, rtol=1e-9, atol=1e-9)
    # a hole has the mesh on its left, too: it is run through clockwise
    back = np.conj(z)
    outside = np.angle((np.roll(back, 1) - back) / (np.roll(back, -1) - back)) % (2 * np.pi)
    np.testing.assert_allclose(inscribed_sums(ratios(back), True), outside, rtol=1e-9, atol=1e-9)


def test_sides_that_close_no_polygon_share_the_circle_by_their_lengths() -> None:
    length = np.array([1.0, 5.0, 1.5, 2.0])
    log = np.log(length)
    np.testing.assert_allclose(central_angles(log - np.roll(log, 1)), 2 * np.pi * length / length.sum())


@pytest.mark.parametrize("wave", [1, 2, 3, 7])
@pytest.mark.parametrize("hole", [False, True])
def test_of_each_wave_the_sums_change_by_so_much_more_than_is_missing(wave: int, hole: bool) -> None:
    """The sums change by k times a wave of the scale, those of the circle by one: against it at a hole."""
    n = 200
    angle, side = 2 * np.pi * np.arange(n) / n, 2 * np.pi / n
    scale = 1e-3 * np.cos(wave * angle + 0.4)
    missing = (wave + 1 if hole else wave - 1) * scale * side
    more = predict_change(np.zeros(n), (-side if hole else side) + missing, hole)
    expected = (-1 if hole else wave > 1) * scale * side
    np.testing.assert_allclose(more, expected, atol=1e-12)
