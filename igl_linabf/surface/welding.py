"""Vertices in one place made one."""

import numpy as np
import scipy

from .._core import sum_by
from .._types import FloatArray, IntArray
from ..errors import MeshError, is_number
from .components import connected_labels

LOOSE = 2  # faces of a piece that may be one of a soup: a triangle or a quadrangle
SIDES = 4  # pieces from which on larger flat ones are, too: a body has so many sides
FLAT = 1e-6  # share of its area that a flat piece loses when it is projected
SOUP = 0.5  # share of faces in such pieces from which on they are a soup


def is_soup(V: FloatArray, F: IntArray, label: IntArray) -> bool:
    """Whether most faces have vertices of their own, or those of a quadrangle's two, or of one flat side.

    `label` is the component of each face.
    """
    size = np.bincount(label)
    loose = size <= LOOSE
    if len(size) >= SIDES and not loose.all():
        a, b, c = V[F.T]
        with np.errstate(over="ignore", invalid="ignore"):
            normal = np.cross(b - a, c - a)
            first = np.unique(label, return_index=True)[1]  # faces may run either way around
            along = np.sign((normal * normal[first[label]]).sum(axis=1))
            total = np.stack([sum_by(label, along * x, len(size)) for x in normal.T])
            area = sum_by(label, np.linalg.norm(normal, axis=1), len(size))
            loose |= np.linalg.norm(total, axis=0) >= (1 - FLAT) * area
    return bool(loose[label].mean() > SOUP)


def in_one_place(V: FloatArray, used: IntArray) -> IntArray:
    """For each vertex the first of the `used` ones in the same place, to the bit."""
    points = V[used] + 0.0  # -0 is 0
    order = np.lexsort(points.T)
    new = np.append(True, (points[order[1:]] != points[order[:-1]]).any(axis=1))
    first = np.minimum.reduceat(order, np.flatnonzero(new))
    merged = np.arange(len(V))
    merged[used[order]] = used[first[np.cumsum(new) - 1]]
    return merged


def within(V: FloatArray, used: IntArray, distance: float) -> IntArray:
    """For each vertex the first of those that a chain of steps of at most `distance` leads to.

    Raises
    ------
    ValueError
        `distance` is negative or not finite.
    """
    if not is_number(distance, 0, np.finfo(float).max):
        raise ValueError(f"weld is {distance!r}: give a distance from 0 on, in the units of V")
    if distance == 0:
        return in_one_place(V, used)
    points = V[used]
    size = float(np.abs(points).max(initial=0))
    if size > 1e150:  # squares of larger ones overflow
        raise MeshError(f"vertices have coordinates of {size:.1e}: scale the mesh to weld it")
    pairs = scipy.spatial.cKDTree(points).query_pairs(distance, output_type="ndarray")
    label = connected_labels(pairs, len(used))
    merged = np.arange(len(V))
    merged[used] = used[np.unique(label, return_index=True)[1]][label]
    return merged
