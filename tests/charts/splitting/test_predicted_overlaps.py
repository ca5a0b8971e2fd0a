"""Seams where a map would overlap or shrink tips: found on clusters, before the surface is flattened."""

from __future__ import annotations

import igl
import numpy as np
import pytest

from igl_linabf import unwrap
from igl_linabf.charts.atlas.pieces import flatten_piece
from igl_linabf.charts.seams import search as seams
from igl_linabf.charts.splitting import predicted_overlaps
from igl_linabf.flattening import Sketch
from igl_linabf.measures import overlapping_pairs
from igl_linabf.surface import Submesh


def test_overlaps_of_large_surfaces_are_predicted() -> None:
    """In a cube with a tunnel through each pair of sides, whose map overlaps if handles alone are opened."""
    x, y, z = np.meshgrid(*3 * [np.linspace(-3, 3, 50)], indexing="ij")
    values = sum(c**4 - 5 * c**2 for c in (x, y, z)) + 11.8
    points = np.column_stack([c.ravel(order="F") for c in (x, y, z)])
    V, F = igl.marching_cubes(values.ravel(order="F"), points, 50, 50, 50, 0.0)[:2]
    surface, overlapping = Submesh.checked_manifold(V, F), []
    for parted in (False, True):
        parts = surface.cut_along(seams.seams_of(surface, 6.0, part_overlaps=parted))
        assert all(not part.topology.genus and len(part.topology.loops) == 1 for part in parts)
        overlapping += [sum(len(overlapping_pairs(flatten_piece(p, Sketch()).uv, p.F)) for p in parts)]
    assert len(parts) <= 4
    assert overlapping[1] <= overlapping[0] / 20


@pytest.mark.parametrize(("share", "cut"), [(0.1, False), (0.8, True)])
def test_overlaps_are_cut_beforehand_only_if_most_of_the_map_is_to_be_made_again(
    share: float, cut: bool
) -> None:
    """A strip along a spiral stair of a turn and a half, of which this share of the faces is in the turns."""
    rows = 400
    turns = int(share * rows)
    t = np.append(np.linspace(-1, 0, rows - turns, endpoint=False), np.linspace(0, 3 * np.pi, turns + 1))
    r, t = np.meshgrid(np.linspace(0.8, 1.2, 5), t)
    on_stair = np.stack((r * np.cos(t), r * np.sin(t), 0.1 * t), axis=-1)
    before = np.stack((r, t, 0.1 * t), axis=-1)
    V = np.where(t[..., None] > 0, on_stair, before).reshape(-1, 3)
    strip = Submesh.checked(V, igl.triangulated_grid(5, rows + 1)[1])
    parts, uv, stays = predicted_overlaps._parts(strip, *predicted_overlaps._sketches([strip]), False)
    assert uv is not None
    assert bool(parts) is cut is not stays


def test_tall_fins_of_a_large_plate_are_predicted_until_none_is_worth_a_seam() -> None:
    """Seams to their tips lay parts over each other, whose tips are seen then: one map shows few of them."""
    x, y = np.meshgrid(*2 * [np.linspace(-1, 1, 120)])
    turns = np.arange(8) * np.pi / 4
    along, across = (
        a * x[..., None] + b * y[..., None]
        for a, b in ((np.cos(turns), np.sin(turns)), (-np.sin(turns), np.cos(turns)))
    )
    z = 1.2 * np.exp(-(((along - 0.55) / 0.25) ** 6) - (across / 0.03) ** 2).max(axis=2)
    V, F = np.column_stack((x.ravel(), y.ravel(), z.ravel())), igl.triangulated_grid(120, 120)[1]
    atlas = unwrap(V, F)
    assert atlas.good
    assert atlas.quality.stretch_l2 <= 4
