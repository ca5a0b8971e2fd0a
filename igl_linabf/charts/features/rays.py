"""Which charts nobody sees: no ray from outside reaches them, as the walls of cavities inside a body."""

from __future__ import annotations

from collections.abc import Sequence

import igl
import numpy as np

from ..._types import BoolArray, FloatArray, IntArray
from ...surface import Submesh
from . import constants


def are_unseen(surface: Submesh, charts: Sequence[IntArray]) -> BoolArray:
    """Of which charts no ray from the centres of some faces leaves the surface, to either side.

    `charts` has the faces of each, as rows of the surface's `F`. The faces are at equal shares of the chart's
    area, and the rays go in the same directions from each: so the answer is the same each time.
    """
    V, F = surface.V, surface.F
    tree, directions = igl.AABB(), _directions(constants.RAYS_OF_FACE)
    tree.init(V, F)
    off = constants.RAY_START * float(np.ptp(V, axis=0).max())
    area = np.cumsum(surface.measured[0])
    unseen = np.ones(len(charts), dtype=bool)
    for share in (np.arange(constants.FACES_WITH_RAYS) + 0.5) / constants.FACES_WITH_RAYS:
        left = np.flatnonzero(unseen)
        if not len(left):
            break
        face = np.array([_face_at(area, charts[i], share) for i in left.tolist()])
        start = V[F[face]].mean(axis=1)[:, None] + off * directions
        rays = np.broadcast_to(directions, start.shape).reshape(-1, 3)
        hit = tree.intersect_ray_first(V, F, np.ascontiguousarray(start.reshape(-1, 3)), rays.copy())[0]
        unseen[left] = (hit.reshape(len(left), -1) >= 0).all(axis=1)
    return unseen


def _face_at(area: FloatArray, faces: IntArray, share: float) -> int:
    """The face of a chart at that share of its area; `area` is summed up over the surface's faces."""
    own = np.cumsum(area[faces] - np.where(faces > 0, area[faces - 1], 0.0))
    return int(faces[np.searchsorted(own[:-1], share * own[-1])])


def _directions(n: int) -> FloatArray:
    """Unit vectors on a spiral around the sphere, which are equally far from each other, (n, 3)."""
    z, turn = (2 * np.arange(n) + 1) / n - 1, np.pi * (3 - np.sqrt(5)) * np.arange(n)
    r = np.sqrt(1 - z**2)
    return np.column_stack((r * np.cos(turn), r * np.sin(turn), z))
