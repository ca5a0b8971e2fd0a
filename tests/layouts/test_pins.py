"""Any number of pins is met if possible; otherwise, the pins are reported."""

from __future__ import annotations

import numpy as np
import pytest
from conftest import load
from own_measures import count_flipped_exactly

from igl_linabf import ABF, LinABF, flatten
from igl_linabf.flattening import Outcome, linabf_angles
from igl_linabf.layouts import layout

NAMES = ("bumps", "cortex", "crown", "disk__igl_camel_b.obj")


def some_vertices(V: np.ndarray, number: int) -> np.ndarray:
    return np.random.default_rng(0).choice(len(V), number, replace=False)


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("number", [3, 20, None])
def test_pins_at_the_positions_of_a_map_reproduce_the_map(name: str, number: int | None) -> None:
    V, F = load(name)
    b = some_vertices(V, len(V) if number is None else number)
    angles = linabf_angles(V, F)
    free = layout(F, angles, b[:2], [[0, 0], [1, 0]], method="least-squares")
    again = layout(F, angles, b, free[b])
    assert np.array_equal(again[b], free[b])
    assert np.abs(again - free).max() <= 1e-8 * np.ptp(free)


@pytest.mark.parametrize("name", NAMES)
def test_least_squares_layouts_meet_pins_and_dncp_agrees_with_lscm(name: str) -> None:
    V, F = load(name)
    b = some_vertices(V, 7)
    bc = np.random.default_rng(1).normal(size=(7, 2))
    made = [
        flatten(V, F, b, bc, method=method)
        for method in (LinABF(layout="least-squares"), "linabf", ABF(), "dncp", "lscm")
    ]
    for result in made:
        assert np.abs(result.uv[b] - bc).max() <= 1e-10
        assert result.report.layout == "least-squares"
        assert (result.outcome is Outcome.FLIPPED) == (count_flipped_exactly(result.uv, F) > 0)
    dncp, by_igl = (result.uv for result in made[-2:])
    assert np.abs(by_igl - dncp).max() <= 1e-6


@pytest.mark.parametrize("name", NAMES)
def test_two_pins_are_met_by_every_layout(name: str) -> None:
    V, F = load(name)
    b, bc = some_vertices(V, 2), np.array([[3.0, 1.0], [3.0, -0.5]])
    for method in ("linabf", "abf", "isometric", LinABF(iterations=1), LinABF(layout="greedy")):
        assert np.abs(flatten(V, F, b, bc, method=method).uv[b] - bc).max() <= 1e-10


@pytest.mark.parametrize("name", ["bumps", "crown", "disk__igl_camel_b.obj"])
@pytest.mark.parametrize("method", ["isometric", LinABF(guarantee="injective")])
def test_pins_are_met_without_flips(name: str, method: str | LinABF) -> None:
    V, F = load(name)
    free = flatten(V, F, method="isometric").uv
    b = some_vertices(V, 5)
    bc = 3 * free[b] * [1.1, 0.9] + 5
    result = flatten(V, F, b, bc, method=method)
    assert not len(result.flipped)
    assert np.array_equal(result.uv[b], bc)
    assert count_flipped_exactly(result.uv, F) == 0


def test_pins_of_an_isometric_map_reproduce_the_map_at_any_place_and_scale() -> None:
    V, F = load("bumps")
    free = flatten(V, F, method="isometric").uv
    turn = 1e3 * np.array([[0.6, 0.8], [-0.8, 0.6]])
    for b in (some_vertices(V, 2), some_vertices(V, 9)):
        result = flatten(V, F, b, free[b] @ turn + 7, method="isometric")
        assert np.abs(result.uv - (free @ turn + 7)).max() <= 1e-4 * np.ptp(result.uv)


def test_unreachable_pins_are_reported() -> None:
    V, F = load("bumps")
    free = flatten(V, F, method="isometric").uv
    b = np.array([*F[400], *some_vertices(V, 6)])
    bc = free[b]
    bc[:2] = bc[1::-1]  # swapping two pins reverses a triangle
    held, isometric = flatten(V, F, b, bc, method="linabf"), flatten(V, F, b, bc, method="isometric")
    assert held.outcome is Outcome.FLIPPED
    assert "pins may require" in held.message
    assert isometric.outcome is Outcome.NOT_CONVERGED
    assert "pins are missed by up to" in isometric.message
    assert count_flipped_exactly(isometric.uv, F) == 0


@pytest.mark.parametrize("method", [LinABF(layout="boundary"), LinABF(layout="greedy"), "scp"])
def test_maps_that_are_only_moved_to_their_pins_take_two_pins(method: str | LinABF) -> None:
    V, F = load("bumps")
    with pytest.raises(ValueError, match="only moved to its pins, and there are 3"):
        flatten(V, F, [1, 2, 3], [[0, 0], [1, 0], [0, 1]], method=method)
