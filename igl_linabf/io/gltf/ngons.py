"""Encode polygons as glTF triangles by the extension FB_ngon_encoding.

Consecutive triangles that begin with the same vertex form one polygon, split into a fan around this vertex.
"""

import numpy as np

from ..._types import IntArray
from ...surface import Polygons, Triangles

EXTENSION = "FB_ngon_encoding"


def order_as_fans(split: Triangles, corners: IntArray) -> IntArray:
    """Return the triangles (#T, 3) in an order that encodes the polygons as fans.

    Polygons whose triangles do not all share a corner are written as separate triangles.

    Parameters
    ----------
    split : Triangles
    corners : (#C,) int64
        The written vertices at the corners of the polygons.
    """
    place = split.place
    count = np.bincount(split.face, minlength=len(split.polygons))[split.face]
    # number of triangles at each polygon corner
    occurrences = np.bincount(place.ravel(), minlength=len(split.polygons.corners))
    centre = occurrences[place] == count[:, None]
    starts = corners[place]
    no_centre = ~centre.any(axis=1)
    head = np.flatnonzero(np.append(True, (split.face[1:] != split.face[:-1]) | no_centre[1:]))
    length = np.diff(head, append=len(place))
    candidates = np.where(centre | no_centre[:, None], np.arange(3), -1)[head].tolist()
    turn, before = np.empty(len(head), dtype=np.int64), -1
    for i, (row, options) in enumerate(zip(starts[head].tolist(), candidates, strict=True)):
        choice = next((k for k in options if k >= 0 and row[k] != before), max(options))
        turn[i], before = choice, row[choice]
    # rotate the triangles of each fan to begin with the centre, and sort them around the centre
    centre_place = np.repeat(place[head, turn], length)
    shift = np.argmax(place == centre_place[:, None], axis=1)
    rotated = np.take_along_axis(place, (shift[:, None] + np.arange(3)) % 3, axis=1)
    sizes = split.polygons.sizes[split.face]
    around = (rotated[:, 1] - rotated[:, 0]) % sizes
    order = np.lexsort((around, np.repeat(np.arange(len(head)), length)))
    return np.asarray(corners[rotated[order]])


def reverse_polygons(polygons: Polygons) -> Polygons:
    """Return the polygons with reversed orientation and the same first corners."""
    place = np.arange(len(polygons.corners))
    start = polygons.starts[polygons.polygon_of_corner]
    back = start + (start - place) % polygons.sizes[polygons.polygon_of_corner]
    return Polygons(polygons.corners[back], polygons.sizes)


def merge_fans(F: IntArray) -> Polygons:
    """Return the polygons that triangles (#T, 3) in fan order encode."""
    follows = (F[1:, 0] == F[:-1, 0]) & (F[1:, 1] == F[:-1, 2])
    head = np.flatnonzero(np.append(True, ~follows)) if len(F) else np.zeros(0, dtype=np.int64)
    sizes = np.diff(head, append=len(F)) + 2
    corners = np.empty(int(sizes.sum()), dtype=np.int64)
    start = np.cumsum(sizes) - sizes
    corners[start], corners[start + 1] = F[head, 0], F[head, 1]
    rest = np.ones(len(corners), dtype=bool)
    rest[start] = rest[start + 1] = False
    corners[rest] = F[:, 2]
    return Polygons(corners, sizes)
