"""Charts are cut in two along the shortest seam between two sets of polygons."""

from __future__ import annotations

import igl
import numpy as np
import pytest

from igl_linabf.charts.least_cuts import (
    divide_at_least_cut,
    find_edges_between_polygons,
    find_terminals_beside_line,
)
from igl_linabf.charts.splitting import bisect_piece
from igl_linabf.surface import Submesh


def hourglass(waist: float) -> Submesh:
    """Return a strip of length 1 that is narrowest at a waist."""
    V, F = igl.triangulated_grid(41, 9)
    x, y = V[:, 0] / V[:, 0].max(), V[:, 1] / V[:, 1].max()
    return Submesh.from_input(np.column_stack((x, y * (0.1 + 0.4 * np.abs(x - waist)), np.zeros(len(V)))), F)


@pytest.mark.parametrize("waist", [0.425, 0.5, 0.6])
def test_a_chart_is_halved_at_the_narrowest_place_near_its_middle(waist: float) -> None:
    piece = hourglass(waist)
    one, other = bisect_piece(piece)
    seam = np.intersect1d(one.vertices, other.vertices)
    np.testing.assert_allclose(piece.V[seam, 0], waist, atol=1e-9)
    assert len(seam) == 9


def test_a_waist_far_from_the_middle_is_not_used() -> None:
    piece = hourglass(0.1)
    sizes = [part.areas_and_products[0].sum() for part in bisect_piece(piece)]
    assert min(sizes) > 0.25 * sum(sizes)


def test_the_seam_is_as_short_as_any_between_the_terminals() -> None:
    """Edges have random lengths; the seam is compared with all cuts between columns of faces."""
    piece, rng = hourglass(0.5), np.random.default_rng(4)
    sides, length = find_edges_between_polygons(piece)
    length = length * rng.uniform(0.2, 2.0, len(length))
    x = piece.V[piece.F].mean(axis=1)[:, 0]
    terminal = find_terminals_beside_line(x - 0.5, 0.3)

    def cost(beyond: np.ndarray) -> float:
        return float(length[beyond[sides[0]] != beyond[sides[1]]].sum())

    found = divide_at_least_cut(sides, length, terminal)
    assert not found[terminal == 0].any() and found[terminal == 1].all()
    columns = [cost(x > at) for at in np.linspace(0.22, 0.78, 100)]
    one_more = [cost(found ^ (np.arange(len(x)) == k)) for k in np.flatnonzero(terminal < 0)]
    assert cost(found) <= (1 + 1e-5) * min(*columns, *one_more)
    assert not divide_at_least_cut(sides, length, np.minimum(terminal, 0)).any()
