"""Read OFF, COFF, NOFF and STOFF, in text."""

import re
from itertools import pairwise

import numpy as np

from .mesh_file import MeshFile
from .parsing import Damaged, Property, columns_of, indices, polygons_of, refuse, rows_of

VERTEX = tuple(Property(axis, "f8") for axis in "xyz")
FACE = (Property("corners", "i4", "i4"),)
# Digits of a face's number of corners, at most: Python refuses to read numbers of thousands of digits. With
# fewer, long polygons are refused; more fit no list of a file (tests/io/test_formats.py).
CORNER_COUNT_DIGITS = 9
NO_FACE = "is no face: it takes a number from 3 on and as many vertex indices"


def parse_off(data: bytes) -> MeshFile:
    """The mesh in the bytes of an OFF file; colours and the like at the end of a line are ignored."""
    rows, at = rows_of(data, b"#")
    rows[:1] = [re.sub(rb"OFF(?=\d)", b"OFF ", row, count=1) for row in rows[:1]]  # some leave the blank out
    head = rows[0].split() if rows else [b""]
    if not re.fullmatch(rb"(ST)?C?N?OFF", head[0]):
        raise Damaged("it does not begin with OFF, COFF, NOFF or STOFF (text, in three dimensions)")
    if head[1:] == [b"BINARY"]:
        raise Damaged("it is a binary OFF: export it as text, or as PLY, from the program that wrote it")
    first = 1 if len(head) == 1 else 0  # the row of the counts, which may follow at once
    words = rows[first].split()[1 - first :][:2] if first < len(rows) else []
    counts = indices(words, 2)
    if not counts:
        raise Damaged(f"after {head[0].decode()} the numbers of vertices and faces are missing")
    n, m = counts
    rows, at = rows[first + 1 :], at[first + 1 :]
    if len(rows) != n + m and head[0] == b"OFF":
        rows, at = _one_a_line(rows, at, n, m)
    if len(rows) != n + m:
        raise Damaged(
            f"its head promises {n} vertices and {m} faces, and {len(rows)} lines follow: correct the head "
            "if these are all"
        )
    points = columns_of(rows[:n], at[:n], VERTEX, "is no vertex: it takes three numbers")
    rows, at = rows[n:], at[n:]
    polygons = columns_of(rows, at, FACE, NO_FACE)["corners"]
    for i in np.flatnonzero(np.asarray(polygons.sizes) < 3)[:1]:
        refuse(at[i], rows[i], NO_FACE)
    faces = polygons_of(polygons)
    for i in faces.outside(n)[:1]:
        refuse(at[i], rows[i], f"names a vertex outside 0..{n - 1}")
    return MeshFile(np.column_stack([points[axis].values for axis in "xyz"]), faces)


def _one_a_line(rows: list[bytes], at: list[int], n: int, m: int) -> tuple[list[bytes], list[int]]:
    """A row for each vertex and face whose words are spread over lines; else the rows given."""
    words = [(word, line) for row, line in zip(rows, at, strict=True) for word in row.split()]
    if len(words) < 3 * n + m:
        return rows, at
    starts = list(range(0, 3 * n + 1, 3))
    for _ in range(m):
        size = words[starts[-1]][0] if starts[-1] < len(words) else b""
        if not size.isdigit() or len(size) > CORNER_COUNT_DIGITS or int(size) > len(words):
            return rows, at
        starts.append(starts[-1] + 1 + int(size))
    if starts[-1] != len(words):
        return rows, at
    joined = [b" ".join(word for word, _ in words[i:j]) for i, j in pairwise(starts)]
    return joined, [words[i][1] for i in starts[:-1]]
