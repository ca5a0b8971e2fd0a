"""Where a seam shows: less in valleys, and less where the caller wants it hidden.

All is smoothed over `REACH`, so that noise and single faces do not matter.
"""

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import sparse

from .._types import FloatArray, IntArray
from ..errors import MeshError, some
from ..kernels import entries
from ..surface import Submesh

REACH = 0.02  # times the square root of the area: how far values are smoothed
MAX_STEPS = 30  # of smoothing
VALLEY_DISCOUNT = 0.5  # share of its length that an edge in a deep valley is shorter by
VALLEY = 10.0  # curvature times size at which half of that is given
HIDING = 3.0  # times its length counts an edge where nothing is hidden, and by this is it divided in hiding


def hiding(surface: Submesh, hide: ArrayLike | None, face: IntArray) -> FloatArray | None:
    """How well each triangle hides a seam, from -1 to 1; None if it does not matter.

    `hide` is a direction, (3,), or the weights of the caller's faces; `face` is that of each triangle.
    """
    if hide is None:
        return None
    try:
        given = np.asarray(hide, dtype=np.float64)
    except (TypeError, ValueError):
        raise MeshError("hide is no array of numbers: pass a direction (3,), or a weight a face") from None
    n_faces = int(face[-1]) + 1
    if given.shape not in ((3,), (n_faces,)):
        raise MeshError(
            f"hide has the shape {given.shape}: pass a direction, (3,), or weights of the {n_faces} faces"
        )
    bad = np.flatnonzero(~np.isfinite(given))
    if len(bad):
        raise MeshError(f"hide is NaN or infinite at {some(bad)}: give finite numbers")
    if given.shape == (3,):
        made = np.zeros(len(face))
        made[surface.faces] = _facing(surface, given)
        return made
    low, high = float(given.min()), float(given.max())
    return ((given - low) / (high - low) * 2 - 1)[face] if high > low else np.zeros(len(face))


def _facing(surface: Submesh, direction: FloatArray) -> FloatArray:
    """Cosine of the angle between a direction and the outer normal of each face."""
    length = float(np.linalg.norm(direction))
    if length == 0:
        raise MeshError("hide is a direction of no length: point to where seams are to be")
    facing = np.empty(len(surface.F))
    for part in surface.components():
        a, b, c = part.V[part.F.T] - part.V.mean(axis=0)
        normal = np.cross(b - a, c - a)
        inward = not part.topology.loops and float((a * normal).sum()) < 0
        norm = np.maximum(np.linalg.norm(normal, axis=1), np.finfo(float).tiny)
        cosine = normal @ (direction / length) / norm
        facing[np.searchsorted(surface.faces, part.faces)] = -cosine if inward else cosine
    return facing


class Smoothing:
    """Averages over neighbours, repeated until they reach over `REACH`."""

    def __init__(self, component: Submesh, edges: IntArray, length: FloatArray, size: float) -> None:
        n = len(component.V)
        indptr, indices, _ = entries(edges.T, n)
        upper = sparse.csr_array((np.ones(len(indices)), indices, indptr), shape=(n, n))
        self._around = (upper + upper.T.tocsr()).tocsr()
        self._around.data[:] = 1  # on the diagonal, too
        self._number = self._around.sum(axis=1)
        step = float(np.median(length)) if len(length) else size
        self._steps = int(np.clip(round((REACH * size / step) ** 2), 1, MAX_STEPS))

    def of(self, values: NDArray[Any]) -> FloatArray:
        """Smoothed values of the vertices."""
        for _ in range(self._steps):
            values = self._around @ values / self._number
        return np.asarray(values)


def valleys(
    component: Submesh,
    edges: IntArray,
    length: FloatArray,
    bend: FloatArray,
    smoothing: Smoothing,
    size: float,
) -> FloatArray:
    """What a seam's length is multiplied by at each edge: less than 1 in concave valleys."""
    n, double_area = len(component.V), component.measured[0]
    half = bend * length / 2
    turned = np.bincount(edges[:, 0], half, minlength=n) + np.bincount(edges[:, 1], half, minlength=n)
    area = np.bincount(component.F.T.ravel(), np.tile(double_area / 6, 3), minlength=n)
    depth = np.maximum(-smoothing.of(turned) / smoothing.of(area) * size, 0)
    depth = (depth[edges[:, 0]] + depth[edges[:, 1]]) / 2
    return np.asarray(1 - VALLEY_DISCOUNT * depth / (depth + VALLEY))


def shown(component: Submesh, edges: IntArray, hidden: FloatArray, smoothing: Smoothing) -> FloatArray:
    """What a seam's length is multiplied by at each edge, as `hidden` says of the caller's faces."""
    n, double_area = len(component.V), component.measured[0]
    corner = component.F.T.ravel()
    area = np.bincount(corner, np.tile(double_area, 3), minlength=n)
    mean = np.bincount(corner, np.tile(double_area * hidden[component.faces], 3), minlength=n) / area
    return np.asarray(HIDING ** -smoothing.of(mean)[edges].mean(axis=1))
