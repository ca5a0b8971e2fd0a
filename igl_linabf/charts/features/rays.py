"""Find charts that cannot be seen from outside, such as the walls of a cavity, by tracing rays."""

from __future__ import annotations

from collections.abc import Sequence

import igl
import numpy as np

from ..._types import BoolArray, FloatArray, IntArray

FACES_WITH_RAYS = 8  # number of faces of each chart that emit rays
RAYS_OF_FACE = 100  # number of rays that start at each sampled face
RAY_START = 1e-6  # distance between the start of a ray and its face, relative to the extent of the surface


def find_unseen_charts(V: FloatArray, F: IntArray, charts: Sequence[IntArray]) -> BoolArray:
    """Return a mask of the charts that are invisible from outside: rays from them never leave the surface.

    Rays start at the centres of a few faces of each chart, on both sides. `charts` has the faces of each
    chart as rows of `F`. The result is deterministic: the sampled faces are spaced evenly by area, and the
    rays have the same directions at each face.
    """
    tree, directions = igl.AABB(), _make_ray_directions(RAYS_OF_FACE)
    tree.init(V, F)
    off = RAY_START * float(np.ptp(V[F], axis=(0, 1)).max())
    shares = (np.arange(FACES_WITH_RAYS) + 0.5) / FACES_WITH_RAYS
    area = igl.doublearea(V, F)
    sampled = np.array([_sample_faces(area, faces, shares) for faces in charts])
    unseen = np.ones(len(charts), dtype=bool)
    for face in sampled.T:
        left = np.flatnonzero(unseen)
        if not len(left):
            break
        start = V[F[face[left]]].mean(axis=1)[:, None] + off * directions
        rays = np.tile(directions, (len(left), 1))
        hit = tree.intersect_ray_first(V, F, start.reshape(-1, 3), rays)[0]
        unseen[left] = (hit.reshape(len(left), -1) >= 0).all(axis=1)
    return unseen


def _sample_faces(area: FloatArray, faces: IntArray, shares: FloatArray) -> IntArray:
    """Return the faces of a chart at which the cumulative area reaches the given shares of the total."""
    own = np.cumsum(area[faces])
    return np.asarray(faces[np.searchsorted(own[:-1], shares * own[-1])])


def _make_ray_directions(n: int) -> FloatArray:
    """Return unit vectors on a spiral around the sphere, evenly distributed, (n, 3)."""
    z, turn = (2 * np.arange(n) + 1) / n - 1, np.pi * (3 - np.sqrt(5)) * np.arange(n)
    r = np.sqrt(1 - z**2)
    return np.column_stack((r * np.cos(turn), r * np.sin(turn), z))
