"""Charts that cannot be seen from outside, such as the walls of a cavity: no ray reaches them."""

from __future__ import annotations

from collections.abc import Sequence

import igl
import numpy as np

from ..._types import BoolArray, FloatArray, IntArray

FACES_WITH_RAYS = 8  # faces of a chart from which rays start
RAYS_OF_FACE = 100  # rays from each of them
RAY_START = 1e-6  # distance of a ray's start from its face over the surface's extent


def are_unseen(V: FloatArray, F: IntArray, charts: Sequence[IntArray]) -> BoolArray:
    """Of which charts no ray from the centres of some faces leaves the surface, to either side.

    `charts` has the faces of each, as rows of `F`. The faces are at equal shares of the chart's area, and the
    rays go in the same directions from each: so the answer is the same each time.
    """
    tree, directions = igl.AABB(), _directions(RAYS_OF_FACE)
    tree.init(V, F)
    off = RAY_START * float(np.ptp(V[F], axis=(0, 1)).max())
    shares = (np.arange(FACES_WITH_RAYS) + 0.5) / FACES_WITH_RAYS
    area = igl.doublearea(V, F)
    sampled = np.array([_faces_at(area, faces, shares) for faces in charts])
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


def _faces_at(area: FloatArray, faces: IntArray, shares: FloatArray) -> IntArray:
    """The faces of a chart at these shares of its area."""
    own = np.cumsum(area[faces])
    return np.asarray(faces[np.searchsorted(own[:-1], shares * own[-1])])


def _directions(n: int) -> FloatArray:
    """Unit vectors on a spiral around the sphere, which are equally far from each other, (n, 3)."""
    z, turn = (2 * np.arange(n) + 1) / n - 1, np.pi * (3 - np.sqrt(5)) * np.arange(n)
    r = np.sqrt(1 - z**2)
    return np.column_stack((r * np.cos(turn), r * np.sin(turn), z))
