"""Ragged arrays: rows of different lengths, stored one after another in a flat array."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, partialmethod

import numpy as np

from .._types import Array, IntArray


@dataclass(frozen=True, eq=False)
class Ragged:
    """A division of a flat array into rows: row i is `values[..., start[i]:start[i + 1]]`.

    It describes, for example, the vertices or faces of several concatenated meshes. Rows may be empty.

    Attributes
    ----------
    start : (#rows + 1,) int64
        Index of the first element of each row, followed by the number of elements.

    Examples
    --------
    >>> rows = Ragged.from_sizes([2, 0, 3])
    >>> rows.sum(np.array([1, 2, 3, 4, 5])).tolist(), rows.repeat(np.array([7, 8, 9])).tolist()
    ([3, 0, 12], [7, 7, 9, 9, 9])
    """

    start: IntArray

    @classmethod
    def from_sizes(cls, sizes: Sequence[int] | IntArray) -> Ragged:
        """Return the division of a flat array into rows of the given lengths."""
        start = np.zeros(len(sizes) + 1, dtype=np.int64)
        np.cumsum(sizes, out=start[1:])
        return cls(start)

    def __len__(self) -> int:
        return len(self.start) - 1

    @cached_property
    def sizes(self) -> IntArray:
        """Length of each row, (#rows,) int64."""
        return np.diff(self.start)

    @cached_property
    def next_element(self) -> IntArray:
        """Index of the next element of the same row, cyclically."""
        after = np.arange(1, self.start[-1] + 1)
        filled = self.sizes > 0
        after[self.start[1:][filled] - 1] = self.start[:-1][filled]
        return after

    def reduce_rows(self, ufunc: np.ufunc, values: Array) -> Array:
        """Reduce each row with `ufunc`; the result of an empty row is 0."""
        if len(self) and self.sizes.all():
            return np.asarray(ufunc.reduceat(values, self.start[:-1], axis=-1))
        made = np.zeros((*values.shape[:-1], len(self)), dtype=values.dtype)
        filled = np.flatnonzero(self.sizes)
        if len(filled):
            made[..., filled] = ufunc.reduceat(values, self.start[filled], axis=-1)
        return made

    sum = partialmethod(reduce_rows, np.add)
    max = partialmethod(reduce_rows, np.maximum)
    min = partialmethod(reduce_rows, np.minimum)
    any = partialmethod(reduce_rows, np.logical_or)

    def repeat(self, values: Array) -> Array:
        """Repeat one value per row for all elements of the row."""
        return np.repeat(values, self.sizes, axis=-1)

    def split(self, values: Array) -> list[Array]:
        """Return a list of the rows of a flat array."""
        start = self.start.tolist()
        return list(map(values.__getitem__, map(slice, start, start[1:])))

    def cumsum(self, values: Array) -> Array:
        """Return the cumulative sums of the elements of each row."""
        made = np.empty_like(values)
        # sum rows of similar length in one table; one sum over all rows would carry rounding errors across
        width = np.ceil(np.log2(np.maximum(self.sizes, 1))).astype(np.int64)
        for w in np.unique(width):
            chosen = np.flatnonzero((width == w) & (self.sizes > 0))
            if len(chosen):
                at = np.arange(self.sizes[chosen].max())
                inside = at < self.sizes[chosen][:, None]
                index = (self.start[chosen][:, None] + at)[inside]
                table = np.zeros(inside.shape, dtype=values.dtype)
                table[inside] = values[index]
                made[index] = np.cumsum(table, axis=1)[inside]
        return made


def index_and_rank(count: IntArray) -> tuple[IntArray, IntArray]:
    """Repeat each index `count` times, and number the repetitions: [2, 0, 1] gives [0, 0, 2], [0, 1, 0]."""
    index = np.repeat(np.arange(len(count)), count)
    return index, np.arange(len(index)) - np.repeat(np.cumsum(count) - count, count)
