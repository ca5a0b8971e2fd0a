"""What is seen from outside: charts that rays reach, and charts that none does."""

from __future__ import annotations

import igl
import numpy as np
import pytest

from igl_linabf.charts.features.rays import unseen_charts

Surface = tuple[np.ndarray, np.ndarray]


def ball(radius: float, inwards: bool = False, centre: tuple[float, ...] = (0, 0, 0)) -> Surface:
    V, F = igl.icosahedron()
    for _ in range(2):
        V, F = igl.loop(V, F)
    V = V / np.linalg.norm(V, axis=1)[:, None] * radius + centre
    return V, F[:, ::-1] if inwards else F


def unseen(*bodies: Surface) -> list[bool]:
    """Of bodies, each a chart."""
    first = np.cumsum([0, *(len(V) for V, _ in bodies)])
    V = np.concatenate([V for V, _ in bodies])
    F = np.concatenate([F + n for (_, F), n in zip(bodies, first, strict=False)])
    chart = np.repeat(np.arange(len(bodies)), [len(F) for _, F in bodies])
    return unseen_charts(V, F, np.arange(len(F)), chart).tolist()


@pytest.mark.parametrize("outside_in", [False, True])
@pytest.mark.parametrize("moved", [0.0, 1e6])
def test_a_cavity_and_what_floats_in_it_are_unseen_whichever_way_they_look(
    outside_in: bool, moved: float
) -> None:
    at = (moved, 0.0, 0.0)
    outer, cavity, inner = ball(1, outside_in, at), ball(0.9, not outside_in, at), ball(0.1, outside_in, at)
    beside = ball(0.1, outside_in, (moved + 2, 0, 0))
    assert unseen(outer, cavity, inner, beside) == [False, True, True, False]


def test_walls_may_be_thin() -> None:
    assert unseen(ball(1), ball(1 - 1e-6, inwards=True)) == [False, True]


@pytest.mark.parametrize("inwards", [False, True])
def test_an_open_surface_is_seen_from_whichever_side(inwards: bool) -> None:
    V, F = ball(1, inwards)
    assert unseen((V, F[V[F][:, :, 2].max(axis=1) < 0.9])) == [False]


def test_the_bottom_of_a_deep_bowl_is_seen_until_a_lid_closes_it() -> None:
    def cylinder(radius: float, low: float, inwards: bool) -> tuple[Surface, Surface]:
        angle = np.linspace(0, 2 * np.pi, 24, endpoint=False)
        ring = radius * np.column_stack((np.cos(angle), np.sin(angle)))
        at, k = [np.column_stack((ring, np.full(24, z))) for z in (low, 10.0)], np.arange(24)
        n, turn = (k + 1) % 24, -1 if inwards else 1
        wall = np.concatenate((np.column_stack((k, n, n + 24)), np.column_stack((k, n + 24, k + 24))))
        floor = np.concatenate((at[0], [[0, 0, low]])), np.column_stack((n, k, np.full(24, 24)))[:, ::turn]
        return (np.concatenate(at), wall[:, ::turn]), floor

    bowl = [*cylinder(1, 0, False), *cylinder(0.9, 0.5, True)]
    lid = np.array([[-2, -2, 10], [2, -2, 10], [2, 2, 10], [-2, 2, 10.0]]), np.array([[0, 1, 2], [0, 2, 3]])
    assert unseen(*bowl) == [False] * 4
    assert unseen(*bowl, lid) == [False, False, True, True, False]


def test_the_same_charts_are_unseen_in_any_numbering() -> None:
    V, F = (np.concatenate(rows) for rows in zip(ball(1), ball(0.5), strict=True))
    F = F + np.repeat([0, len(V) // 2], len(F) // 2)[:, None]
    inside = np.repeat([0, 1], len(F) // 2)
    order = np.random.default_rng(0).permutation(len(F))
    assert unseen_charts(V, F[order], np.arange(len(F)), inside[order]).tolist() == [False, True]
    assert unseen_charts(V, F, order, 1 - inside[order]).tolist() == [True, False]
    assert unseen_charts(V, F, np.flatnonzero(inside), inside[inside > 0] - 1).tolist() == [True]
