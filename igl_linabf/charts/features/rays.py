"""What is seen from outside: rays from the faces of a surface, which escape or hit it."""

from __future__ import annotations

import igl
import numpy as np

from ..._types import BoolArray, FloatArray, IntArray
from . import constants


def unseen_charts(V: FloatArray, F: IntArray, faces: IntArray, chart: IntArray) -> BoolArray:
    """Which charts no ray from outside reaches, on neither side of any face that is tried, (#C,).

    Rays leave the centres of faces in directions at random, the same ones for the same input. Charts of which
    none has escaped get more of them. Both sides count, as surfaces may be open or inside out: the back of a
    cavity's wall is within the body, and unseen as well.

    Parameters
    ----------
    V, F : (#V, 3) float64 and (#F, 3) int64
        All that hides.
    faces : (#f,) int64
        Rows of F that belong to charts.
    chart : (#f,) int64
        The chart of each, from 0 on, none of them empty.
    """
    order = np.argsort(chart, kind="stable")
    faces, size = faces[order], np.bincount(chart)
    start, unseen = np.cumsum(size) - size, np.ones(len(size), dtype=bool)
    used = np.unique(F)
    F = np.searchsorted(used, F)
    V = V[used] - V[used].mean(axis=0)
    V = V / max(float(np.abs(V).max(initial=0)), np.finfo(float).tiny)
    tree, rng = igl.AABB(), np.random.default_rng(0)
    tree.init(V, F)
    for rays in constants.RAYS_A_CHART:
        tried = np.repeat(np.flatnonzero(unseen), rays)
        if not len(tried):
            break
        drawn = (rng.random(len(tried)) * size[tried]).astype(np.int64)
        a, b, c = V[F[faces[start[tried] + drawn]].T]
        normal = np.cross(b - a, c - a)
        normal /= np.maximum(np.linalg.norm(normal, axis=1), np.finfo(float).tiny)[:, None]
        along = rng.standard_normal((len(tried), 3))
        along /= np.linalg.norm(along, axis=1)[:, None]
        side = np.sign((along * normal).sum(axis=1))[:, None]
        hit, _, _ = tree.intersect_ray_first(
            V, F, (a + b + c) / 3 + constants.RAY_OFFSET * side * normal, along
        )
        unseen[tried[hit < 0]] = False
    return unseen
