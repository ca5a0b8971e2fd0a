"""Seams to the tips of limbs that a map shrinks."""

from __future__ import annotations

import igl
import numpy as np
import pytest
from nasty_meshes import sphere

from igl_linabf import flatten, unwrap
from igl_linabf.charts.splitting.tips import find_seams_to_tips
from igl_linabf.measures import measure_change
from igl_linabf.surface import Submesh, drop_unused_vertices

LIMBS = np.array([[1, 0, 0], [0, 1, 0], [0, 0.3, 1.0], -np.ones(3) / np.sqrt(3)])
LIMBS /= np.linalg.norm(LIMBS, axis=1)[:, None]


def ball_with_limbs(height: float) -> Submesh:
    """Return a ball with four limbs, open at the bottom."""
    V, F = sphere(5)
    out = 1 + height * np.exp((V @ LIMBS.T - 1) / 0.03).max(axis=1)
    kept, F = drop_unused_vertices(F[V[F][:, :, 2].max(axis=1) > -0.9], len(V))
    return Submesh.from_input((V * out[:, None])[kept], F)


def test_a_seam_ends_at_the_tip_of_each_limb() -> None:
    piece = ball_with_limbs(2.0)
    seam = find_seams_to_tips(piece, measure_change(piece, flatten(piece.V, piece.F).uv), 10.0, None)
    nodes, times = np.unique(seam, return_counts=True)
    ends = piece.V[nodes[times == 1]]
    out = ends[np.linalg.norm(ends, axis=1) > 2]
    assert sorted(np.argmax(out @ LIMBS.T, axis=1).tolist()) == [0, 1, 2, 3]
    (part,) = piece.cut_along(seam)
    assert len(part.topology.loops) == 1


def test_a_ball_without_limbs_gets_no_seam() -> None:
    piece = ball_with_limbs(0.0)
    uv = flatten(piece.V, piece.F).uv
    assert not len(find_seams_to_tips(piece, measure_change(piece, uv), 1.0, None))


@pytest.mark.parametrize("height", [0.0, 0.8])
def test_a_spike_smaller_than_clusters_gets_a_seam_from_the_map(height: float) -> None:
    """A ball of 20,480 triangles with a spike of several hundred triangles."""
    V, F = sphere(5)
    V = V * (1 + height * np.exp((V @ [0.9, 0, 0.436] - 1) / 0.005))[:, None]
    atlas = unwrap(V, F)
    reached = np.linalg.norm(V[atlas.seams], axis=2).max()
    assert (reached > 0.95 * np.linalg.norm(V, axis=1).max()) or not height
    assert atlas.good and atlas.quality.texel_spread < 20


def test_tall_fins_of_a_large_plate_get_seams_to_their_tips() -> None:
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
