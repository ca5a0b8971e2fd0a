"""Read OFF, COFF, NOFF and STOFF, in text."""

from __future__ import annotations

import re

import numpy as np

from .parsing import Damaged, Parsed, Property, columns_of, indices, polygons_of, refuse, rows_of, untextured

VERTEX = tuple(Property(axis, "f8") for axis in "xyz")
FACE = (Property("corners", "i4", "i4"),)
NO_FACE = "is no face: it takes a number from 3 on and as many vertex indices"


def parse_off(data: bytes) -> Parsed:
    """The mesh in the bytes of an OFF file; colours and the like at the end of a line are ignored."""
    rows, at = rows_of(data, b"#")
    head = rows[0].split() if rows else [b""]
    if not re.fullmatch(rb"(ST)?C?N?OFF", head[0]):
        raise Damaged("it does not begin with OFF, COFF, NOFF or STOFF (text, in three dimensions)")
    first = 1 if len(head) == 1 else 0  # the row of the counts, which may follow at once
    words = rows[first].split()[1 - first :][:2] if first < len(rows) else []
    counts = indices(words, 2)
    if not counts:
        raise Damaged(f"after {head[0].decode()} the numbers of vertices and faces are missing")
    n, m = counts
    rows, at = rows[first + 1 :], at[first + 1 :]
    if len(rows) != n + m:
        raise Damaged(f"its head promises {n} vertices and {m} faces, and {len(rows)} lines follow")
    points = columns_of(rows[:n], at[:n], VERTEX, "is no vertex: it takes three numbers")
    rows, at = rows[n:], at[n:]
    polygons = columns_of(rows, at, FACE, NO_FACE)["corners"]
    for i in np.flatnonzero(np.asarray(polygons.sizes) < 3)[:1]:
        refuse(at[i], rows[i], NO_FACE)
    faces = polygons_of(polygons)
    for i in faces.outside(n)[:1]:
        refuse(at[i], rows[i], f"names a vertex outside 0..{n - 1}")
    return untextured(np.column_stack([points[axis].values for axis in "xyz"]), faces)
