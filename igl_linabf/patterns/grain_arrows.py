"""Arrows of the grain: where a direction in space points on each piece."""

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial import cKDTree
from shapely import LineString, polygons, unary_union

from .._types import FloatArray, IntArray

HALF = 0.3  # of an arrow, as a share of the piece along it
SHORTER = 0.8  # until the arrow is within the piece
LEAST = 0.1  # of the direction's length that is left on a piece: with less it points nowhere
TINY = 1e-300  # instead of the area of a collapsed triangle


def arrows(
    surface: FloatArray,
    flat: FloatArray,
    F: IntArray,
    loops: tuple[IntArray, ...],
    piece: IntArray,
    grain: ArrayLike,
) -> FloatArray:
    """From where to where each piece's arrow points, (#pieces, 2, 2); the first four are as in `seams_of`.

    Parameters
    ----------
    F : (#f, 3) int64
    grain : (3,) float
        The direction in space. Where it points nowhere, the arrow is along the piece.
    """
    direction = np.asarray(grain, dtype=float)
    if direction.shape != (3,) or not np.linalg.norm(direction) > 0:
        raise ValueError(f"grain is {direction.tolist()}: give a direction in space, three numbers")
    along, area = _on_map(surface, flat, F, direction)
    found = []
    for i in range(int(piece.max()) + 1):
        faces = np.flatnonzero(piece[F[:, 0]] == i)
        mean = (along[faces] * area[faces, None]).sum(axis=0) / area[faces].sum() / np.linalg.norm(direction)
        points = flat[piece == i]
        if np.linalg.norm(mean) < LEAST:
            mean = np.linalg.svd(points - points.mean(axis=0), full_matrices=False)[2][0]
        rim = np.concatenate([flat[loop] for loop in loops if piece[loop[0]] == i])
        found.append(_within(flat[F[faces]], rim, points, mean / np.linalg.norm(mean)))
    return np.array(found)


def _on_map(
    surface: FloatArray, flat: FloatArray, F: IntArray, direction: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """The direction's part in each triangle, taken to the map, (#f, 2); and their areas on the surface."""
    e, f = (surface[F[:, k]] - surface[F[:, 0]] for k in (1, 2))
    u, v = (flat[F[:, k]] - flat[F[:, 0]] for k in (1, 2))
    ee, ef, ff = (e * e).sum(1), (e * f).sum(1), (f * f).sum(1)
    de, df = e @ direction, f @ direction
    det = np.maximum(ee * ff - ef * ef, TINY)
    along = ((de * ff - df * ef) / det)[:, None] * u + ((df * ee - de * ef) / det)[:, None] * v
    return along, np.sqrt(det) / 2


def _within(
    triangles: FloatArray, rim: FloatArray, points: FloatArray, along: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """An arrow of this direction within a piece, far from its outline."""
    centres = triangles.mean(axis=1)
    room, _ = cKDTree(rim).query(centres)
    at, inside = centres[np.argmax(room)], unary_union(polygons(triangles))
    half = HALF * np.ptp(points @ along)
    while half > room.max() and not inside.contains(LineString((at - half * along, at + half * along))):
        half *= SHORTER
    return at - half * along, at + half * along
