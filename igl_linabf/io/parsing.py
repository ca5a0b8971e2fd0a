"""What the readers of mesh formats share: numbers in words, polygons into triangles, damage."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from ..surface import FloatArray, IntArray

DIGITS = 18  # of an index at most, which 64 bits hold
MOST = 8  # vertices of the polygons that are read at once


class Damaged(Exception):  # noqa: N818  # it is caught where the file's name is known
    """The file is not of its format; the text says where."""


def shown(text: bytes, limit: int = 40) -> str:
    """The beginning of a damaged line, printable."""
    whole = text.decode("utf-8", "backslashreplace")
    return repr(whole if len(whole) <= limit else f"{whole[:limit]}...")


def numbers(words: Sequence[bytes], count: int) -> list[float]:
    """The words as `count` numbers; none where they are not."""
    try:
        values = list(map(float, words))
    except ValueError:
        return []
    # Python, but no format, reads 1_000
    return values if len(values) == count and b"_" not in b"".join(words) else []


def indices(words: Sequence[bytes], count: int) -> list[int]:
    """The words as `count` integers from 0 on; none where they are not."""
    text = b"".join(words)
    if len(words) != count or not text.isdigit() or max(map(len, words)) > DIGITS:
        return []
    return list(map(int, words))


def rows_of(data: bytes, comment: bytes = b"") -> tuple[list[bytes], list[int]]:
    """The lines that are not empty, without comments, and their numbers from 1 on."""
    lines = data.splitlines()
    if comment and comment in data:
        lines = [text.partition(comment)[0] for text in lines]
    lines = list(map(bytes.strip, lines))
    return [text for text in lines if text], [i for i, text in enumerate(lines, 1) if text]


def table(lines: list[bytes], columns: int) -> FloatArray | None:
    """The first `columns` words of each line as numbers, where all of them are: fast."""
    if not lines:
        return np.empty((0, columns))
    try:
        return np.loadtxt(lines, usecols=range(columns), ndmin=2, comments=None)
    except ValueError:
        return None


def table_of_polygons(lines: list[bytes], exact: bool) -> tuple[IntArray, IntArray] | None:
    """Vertices and sizes of polygons in lines `k v1 ... vk`, where all are of one k: fast.

    `exact`: nothing may follow in a line.
    """
    (k,) = indices(lines[0].split()[:1], 1) or (0,) if lines else (0,)
    if not 3 <= k <= MOST or (exact and any(len(text.split()) != k + 1 for text in lines)):
        return None
    rows = table(lines, k + 1)
    if (
        rows is None
        or not (np.abs(rows) < 2.0**53).all()
        or (rows != np.round(rows)).any()
        or (rows[:, 0] != k).any()
    ):
        return None
    return rows[:, 1:].astype(np.int64).ravel(), np.full(len(rows), k)


@dataclass
class Polygons:
    """Polygons one after the other: the vertices of all, and how many each has."""

    corners: list[int] = field(default_factory=list)
    sizes: list[int] = field(default_factory=list)

    def add(self, corners: Sequence[int]) -> None:
        self.corners.extend(corners)
        self.sizes.append(len(corners))

    def arrays(self) -> tuple[IntArray, IntArray]:
        return np.array(self.corners, dtype=np.int64), np.array(self.sizes, dtype=np.int64)


def fan(corners: IntArray, sizes: IntArray) -> tuple[IntArray, IntArray]:
    """Triangles (#F, 3) as igl splits polygons, and the polygon that each is of."""
    of = np.repeat(np.arange(len(sizes)), sizes - 2)
    start = (np.cumsum(sizes) - sizes)[of]
    step = np.arange(len(of)) - (np.cumsum(sizes - 2) - (sizes - 2))[of]
    return corners[np.column_stack((start, start + step + 1, start + step + 2))], of
