"""Ragged arrays: rows of different lengths, one after another in one flat array."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, partialmethod

import numpy as np

from .._types import Array, IntArray


@dataclass(frozen=True, eq=False)
class Ragged:
    """The rows of a flat array: row i is its elements `start[i]` to `start[i + 1]` along the last axis.

    Several meshes side by side have such arrays, with a row a mesh. A row may be empty.

    Attributes
    ----------
    start : (#rows + 1,) int64

    Examples
    --------
    >>> rows = Ragged.of_sizes([2, 0, 3])
    >>> rows.sum(np.array([1, 2, 3, 4, 5])).tolist(), rows.repeat(np.array([7, 8, 9])).tolist()
    ([3, 0, 12], [7, 7, 9, 9, 9])
    """

    start: IntArray

    @classmethod
    def of_sizes(cls, sizes: Sequence[int] | IntArray) -> Ragged:
        """Rows of these lengths."""
        start = np.zeros(len(sizes) + 1, dtype=np.int64)
        np.cumsum(sizes, out=start[1:])
        return cls(start)

    def __len__(self) -> int:
        return len(self.start) - 1

    @cached_property
    def sizes(self) -> IntArray:
        """(#rows,) int64."""
        return np.diff(self.start)

    @cached_property
    def following(self) -> IntArray:
        """The index of the next element of the same row, for each; the first one follows the last."""
        after = np.arange(1, self.start[-1] + 1)
        filled = self.sizes > 0
        after[self.start[1:][filled] - 1] = self.start[:-1][filled]
        return after

    def reduce(self, ufunc: np.ufunc, values: Array) -> Array:
        """The reduction of each row; 0 of an empty one."""
        if len(self) and self.sizes.all():
            return np.asarray(ufunc.reduceat(values, self.start[:-1], axis=-1))
        made = np.zeros((*values.shape[:-1], len(self)), dtype=values.dtype)
        filled = np.flatnonzero(self.sizes)
        if len(filled):
            made[..., filled] = ufunc.reduceat(values, self.start[filled], axis=-1)
        return made

    sum = partialmethod(reduce, np.add)
    max = partialmethod(reduce, np.maximum)
    min = partialmethod(reduce, np.minimum)
    any = partialmethod(reduce, np.logical_or)

    def repeat(self, values: Array) -> Array:
        """One value a row, at all elements of the row."""
        return np.repeat(values, self.sizes, axis=-1)

    def split(self, values: Array) -> list[Array]:
        """The rows."""
        start = self.start.tolist()
        return list(map(values.__getitem__, map(slice, start, start[1:])))

    def cumsum(self, values: Array) -> Array:
        """The running sums of each row for itself, as if there were no others."""
        made = np.empty_like(values)
        # rows of about one length side by side in one table; a sum over all would carry rounding along
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
    """Each index `count` times, and the rank of each time: of 2, 0, 1 these are 0 0 2 and 0 1 0."""
    index = np.repeat(np.arange(len(count)), count)
    return index, np.arange(len(index)) - np.repeat(np.cumsum(count) - count, count)
