"""Consecutive parts of an array, as the arrays of several meshes one after the other have them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np

from .._types import Array, IntArray


@dataclass(frozen=True, eq=False)
class Parts:
    """Part i of an array is its elements `start[i]` to `start[i + 1]`, of the last axis; none is possible.

    Attributes
    ----------
    start : (#parts + 1,) int64
    """

    start: IntArray

    @classmethod
    def of_sizes(cls, sizes: Sequence[int] | IntArray) -> Parts:
        """Parts of these sizes."""
        start = np.zeros(len(sizes) + 1, dtype=np.int64)
        np.cumsum(sizes, out=start[1:])
        return cls(start)

    def __len__(self) -> int:
        return len(self.start) - 1

    @cached_property
    def following(self) -> IntArray:
        """Where the next element of the same part is, for each; the first one comes after the last."""
        after = np.arange(1, self.start[-1] + 1)
        after[self.start[1:][self._filled] - 1] = self.start[:-1][self._filled]
        return after

    @cached_property
    def sizes(self) -> IntArray:
        """(#parts,) int64."""
        return np.diff(self.start)

    @cached_property
    def _filled(self) -> IntArray | slice:
        """Those that are not empty."""
        return slice(None) if bool(self.sizes.all()) else np.flatnonzero(self.sizes)

    def _reduced(self, ufunc: np.ufunc, values: Array) -> Array:
        begin = self.start[:-1][self._filled]
        if 0 < len(begin) == len(self):
            return np.asarray(ufunc.reduceat(values, begin, axis=-1))
        made = np.zeros((*values.shape[:-1], len(self)), dtype=values.dtype)
        if len(begin):
            made[..., self._filled] = ufunc.reduceat(values, begin, axis=-1)
        return made

    def sum(self, values: Array) -> Array:
        """Sums over the parts; 0 over an empty one."""
        return self._reduced(np.add, values)

    def max(self, values: Array) -> Array:
        """Largest elements of the parts; 0 of an empty one."""
        return self._reduced(np.maximum, values)

    def min(self, values: Array) -> Array:
        """Smallest elements of the parts; 0 of an empty one."""
        return self._reduced(np.minimum, values)

    def any(self, values: Array) -> Array:
        """Whether an element of a part is true."""
        return self._reduced(np.logical_or, values)

    def spread(self, values: Array) -> Array:
        """One value a part, at all elements of the part."""
        return np.repeat(values, self.sizes, axis=-1)

    def split(self, values: Array) -> list[Array]:
        """The parts."""
        start = self.start.tolist()
        return [values[i:j] for i, j in pairwise(start)]

    def cumsum(self, values: Array) -> Array:
        """The running sums of each part for itself, as if there were no others."""
        made = np.empty_like(values)
        # parts of about one size side by side in one table; a sum over all would carry rounding along
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


def counted(count: IntArray) -> tuple[IntArray, IntArray]:
    """Each index as often as it counts, and which of its times it is: 2, 0, 1 is 0 0 2 and 0 1 0."""
    index = np.repeat(np.arange(len(count)), count)
    return index, np.arange(len(index)) - np.repeat(np.cumsum(count) - count, count)


def at_once(sizes: IntArray, most: int) -> Iterator[tuple[int, int]]:
    """Runs of items, the first one and the end, whose sizes sum up to `most`; a larger item is alone."""
    reached, first = np.cumsum(sizes), 0
    while first < len(sizes):
        before = int(reached[first - 1]) if first else 0
        end = max(first + 1, int(np.searchsorted(reached, before + most, side="right")))
        yield first, end
        first = end
