"""Arrows of the grain: where a direction in space points on each piece."""

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial import cKDTree
from shapely import LineString, polygons, unary_union

from .._types import FloatArray, IntArray
from .constants import ARROW_HALF, ARROW_SHRINKAGE, LEAST_GRAIN


def arrows_of(
    surface: FloatArray,
    flat: FloatArray,
    F: IntArray,
    loops: tuple[IntArray, ...],
    piece: IntArray,
    grain: ArrayLike,
) -> FloatArray:
    """Tail and head of each piece's arrow, (#pieces, 2, 2).

    Parameters
    ----------
    surface, flat, loops, piece : as in `seams_of`
    F : (#f, 3) int64
    grain : (3,) float
        The direction in space. Where it points nowhere, the arrow is along the piece.
    """
    direction = np.asarray(grain, dtype=float)
    if direction.shape != (3,) or not np.linalg.norm(direction) > 0:
        raise ValueError(f"grain is {direction.tolist()}: give a direction in space, three numbers")
    along, area = _project(surface, flat, F, direction)
    found = []
    for i in range(int(piece.max()) + 1):
        faces = np.flatnonzero(piece[F[:, 0]] == i)
        mean = (along[faces] * area[faces, None]).sum(axis=0) / area[faces].sum() / np.linalg.norm(direction)
        points = flat[piece == i]
        if np.linalg.norm(mean) < LEAST_GRAIN:
            mean = np.linalg.svd(points - points.mean(axis=0), full_matrices=False)[2][0]
        rim = np.concatenate([flat[loop] for loop in loops if piece[loop[0]] == i])
        found.append(_longest_arrow(flat[F[faces]], rim, points, mean / np.linalg.norm(mean)))
    return np.array(found)


def _project(
    surface: FloatArray, flat: FloatArray, F: IntArray, direction: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """The direction projected to each triangle and mapped, (#f, 2); and the areas on the surface."""
    e, f = (surface[F[:, k]] - surface[F[:, 0]] for k in (1, 2))
    u, v = (flat[F[:, k]] - flat[F[:, 0]] for k in (1, 2))
    ee, ef, ff = (e * e).sum(1), (e * f).sum(1), (f * f).sum(1)
    de, df = e @ direction, f @ direction
    det = np.maximum(ee * ff - ef * ef, np.finfo(float).tiny)  # a collapsed triangle has none
    along = ((de * ff - df * ef) / det)[:, None] * u + ((df * ee - de * ef) / det)[:, None] * v
    return along, np.sqrt(det) / 2


def _longest_arrow(
    triangles: FloatArray, rim: FloatArray, points: FloatArray, along: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Tail and head of an arrow of this direction within a piece, about a point far from its outline."""
    centres = triangles.mean(axis=1)
    room, _ = cKDTree(rim).query(centres)
    at, inside = centres[np.argmax(room)], unary_union(polygons(triangles))
    half = ARROW_HALF * np.ptp(points @ along)
    while half > room.max() and not inside.contains(LineString((at - half * along, at + half * along))):
        half *= ARROW_SHRINKAGE
    return at - half * along, at + half * along
