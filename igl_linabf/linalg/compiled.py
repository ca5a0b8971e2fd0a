"""The Cholesky factor by compiled loops over supernodes, by as many threads as there are cores."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property, partial
from heapq import heapify, heappop, heappush
from typing import TYPE_CHECKING, Any, TypeAlias
from weakref import finalize

import numpy as np
from scipy import sparse

from .. import kernels
from .._runtime import at_once, unfilled
from .._types import FloatArray, IntArray, Solve
from . import memory
from .factors import BLOCKS_UP_TO, Analysis, Factored, NotConvergedError, NotPositiveDefiniteError
from .krylov import conjugate_gradients

if TYPE_CHECKING:
    from .sparsity import Symmetric

Inverse: TypeAlias = "partial[FloatArray]"
Precision = type[np.float64] | type[np.float32]

DIVIDED_FROM = 20_000  # rows from which threads save more time than they take to begin
DISSECTED_FROM = 250_000  # rows from which separators save more time than they take to find
SPARSE_FROM = 20_000  # rows from which it pays to go only where the entries of a right-hand side lead
SINGLE_FROM = 250_000  # rows from which a preconditioner is in single precision: two thirds of the time
REFINED_FROM = 1_000_000  # rows from which a solve, too, is by one, and memory counts
ALL_DIGITS, MOST_TO_REFINE = 1e-10, 20  # relative residual, and steps at most
SHARED_FROM = 1e8  # operations for a supernode above the subtrees from which threads share them
MANY = 8  # right-hand sides, below which they go by pairs
TOGETHER = 16  # right-hand sides that go through the factor at a time: more take memory and no less time
LARGEST, SMALLEST = 0.15, 0.005  # share of the whole work in a subtree

WAYS = {1: (kernels.forward_one, kernels.backward_one), 2: (kernels.forward_two, kernels.backward_two)}


@dataclass(frozen=True, eq=False)
class Divided:
    """The elimination tree in subtrees for threads, and the rest, for any number of threads the same.

    Attributes
    ----------
    parts : kernels.Subtrees
    subtrees : list of ((#,) int64, int)
        Supernodes and root of each, the most work first.
    rest : (#,) int64
        The supernodes above, and the roots.
    runs : list of (int64 array, bool)
        The same in turn; True at supernodes so large that threads share each one's work.
    """

    parts: kernels.Subtrees
    subtrees: list[tuple[IntArray, int]]
    rest: IntArray
    runs: list[tuple[IntArray, bool]]

    @classmethod
    def of(cls, a: kernels.Supernodes) -> Divided:
        size, rows_below = len(a.children), np.diff(a.below_start)
        if len(a.order) < DIVIDED_FROM:
            none, rest = np.zeros(1, dtype=np.int64), np.arange(size)
            return cls(kernels.Subtrees(np.full(size, -1), none, none), [], rest, [(rest, False)])
        first, work = kernels.subtrees(a, np.diff(a.value_start).astype(np.float64))
        roots = _roots(np.flatnonzero(rows_below == 0), first, work)
        number, outside = np.full(size, -1, dtype=np.int64), np.ones(size, dtype=bool)
        number[roots] = np.arange(len(roots))
        for root in roots:
            outside[first[root] : root] = False
        rows = rows_below[roots]
        sizes = kernels.padded(rows) ** 2, rows
        parts = kernels.Subtrees(number, *(np.append(0, np.cumsum(size)) for size in sizes))
        chosen = [(np.arange(first[root], root + 1), root) for root in roots]
        rest = np.flatnonzero(outside)
        width = np.diff(a.start)[rest]
        large = (width * (width + rows_below[rest]) ** 2 > SHARED_FROM) & (a.children[rest] > 0)
        large &= number[rest] < 0
        begin = np.flatnonzero(large[1:] | large[:-1]) + 1
        runs = [(run, bool(large[k])) for run, k in zip(np.split(rest, begin), [0, *begin], strict=True)]
        return cls(parts, chosen, rest, runs)


def _roots(tops: IntArray, first: IntArray, work: FloatArray) -> list[int]:
    """Roots of subtrees of much the same work; what is too small for one, or a leaf, is left to the rest."""
    total = work[tops].sum()
    heap = [(-work[s], int(s)) for s in tops]
    heapify(heap)
    while heap and -heap[0][0] > LARGEST * total:
        s = heappop(heap)[1]
        child = s - 1
        while child >= first[s]:
            heappush(heap, (-work[child], child))
            child = int(first[child]) - 1
    return [s for cost, s in sorted(heap) if -cost >= SMALLEST * total and first[s] < s]


@dataclass(frozen=True, eq=False)
class Paths:
    """The ways from rows up the elimination tree.

    Attributes
    ----------
    supernode : (n,) int64
        Of each row.
    parent : list of int
        Of each supernode, -1 if it has none.
    undivided : kernels.Subtrees
        No subtrees for threads.
    """

    supernode: IntArray
    parent: list[int]
    undivided: kernels.Subtrees

    @classmethod
    def of(cls, a: kernels.Supernodes) -> Paths:
        size = len(a.start) - 1
        own = np.empty(len(a.order), dtype=np.int64)
        at = np.repeat(np.arange(size), np.diff(a.start))
        own[a.order] = at
        above = np.append(at, -1)[np.append(a.below, len(at))[a.below_start[:-1]]]
        parent = np.where(np.diff(a.below_start) > 0, above, -1).tolist()
        none = np.zeros(1, dtype=np.int64)
        return cls(own, parent, kernels.Subtrees(np.full(size, -1), none, none))

    def up(self, rows: IntArray) -> list[int]:
        """The supernodes of some rows and all above, in order."""
        seen: set[int] = set()
        for s in self.supernode[rows].tolist():
            while s >= 0 and s not in seen:
                seen.add(s)
                s = self.parent[s]
        return sorted(seen)


class Spare:
    """Arrays that are done with, for the next factor: new memory takes up to a third of its time."""

    def __init__(self) -> None:
        self._kept: dict[int, list[FloatArray]] = {}

    def take(self, size: int) -> FloatArray:
        """An array of this size, which is not filled."""
        try:
            return self._kept[size].pop()
        except LookupError:
            return kernels.fresh(size)

    def give(self, *arrays: FloatArray) -> None:
        for array in arrays:
            self._kept.setdefault(len(array), []).append(array)


class Elimination:
    """The factorisation of the matrices of an analysed pattern."""

    def __init__(self, analysed: kernels.Supernodes) -> None:
        self.analysed, self.divided, self._spare = analysed, Divided.of(analysed), Spare()

    @property
    def bytes(self) -> int:
        """What the factor takes."""
        return 8 * int(self.analysed.value_start[-1])

    def solve(self, data: FloatArray, precision: Precision = np.float64) -> Inverse:
        """The inverse of the matrix with these data, for (n,) or (n, k)."""
        values = self._numeric(data, precision)
        solve = partial(_solved, values.view(precision), self.analysed, self.divided)
        finalize(solve, self._spare.give, values).atexit = False
        return solve

    def _numeric(self, data: FloatArray, precision: Precision) -> FloatArray:
        """The factor's values in the given precision, at the beginning of an array of `Spare`."""
        a, divided, spare = self.analysed, self.divided, self._spare
        # the loops also read up to three numbers after a column, which go nowhere
        values = spare.take(int(a.value_start[-1]) + 3)
        left = spare.take(int(divided.parts.left[-1]))

        def part(root: int, runs: list[tuple[IntArray, bool]]) -> int:
            work = spare.take(a.stack), spare.take(kernels.padded(a.front) ** 2), np.empty(a.front)
            views: list[Any] = [array.view(precision) for array in (values, left, *work)]
            waiting = np.empty(sum(len(run) for run, _ in runs), dtype=np.int64)
            space = kernels.Work(views[2], views[3], views[4], waiting, np.zeros(2, dtype=np.int64))
            to = (*views[:2], space)
            bad = -1
            for run, large in runs:
                if bad < 0 and large:
                    bad = kernels.supernodal_front(data, a, divided.parts, run[0], *to)
                elif bad < 0:
                    bad = int(kernels.supernodal_factor(data, a, divided.parts, run, root, *to))
            spare.give(*work[:2])
            return bad

        bad = max(at_once(lambda s: part(s[1], [(s[0], False)]), divided.subtrees), default=-1)
        if bad < 0:
            bad = part(-1, divided.runs)
        spare.give(left)
        if bad >= 0:
            spare.give(values)
            raise NotPositiveDefiniteError(int(a.order[bad]))
        return values


class Compiled(Analysis):
    """The factorisation of a real matrix by compiled loops."""

    name = "compiled Cholesky"

    def __init__(self, lower: sparse.csc_array) -> None:
        self._pattern = lower.indptr, lower.indices
        ordered = kernels.dissected if lower.shape[0] >= DISSECTED_FROM else kernels.minimum_degree
        self._scalar = Elimination(kernels.supernodes(*self._pattern, ordered(*self._pattern)))

    def factor(self, lower: sparse.csc_array) -> Factored:
        solve = self._solve(lower)
        sparse_pays = lower.shape[0] >= SPARSE_FROM and solve.args[1] is self._scalar.analysed
        halfway = partial(self._halfway, solve) if sparse_pays else None
        return Factored(self.name, True, solve, halfway=halfway)

    @cached_property
    def _paths(self) -> Paths:
        return Paths.of(self._scalar.analysed)

    def _halfway(self, inverse: Inverse, row: IntArray, value: FloatArray) -> FloatArray:
        """`Factored.halfway` by a factor: only supernodes above an entry have to do with it."""
        values, a, _ = inverse.args
        n, number, paths = len(a.order), row.shape[1], self._paths
        reached = np.array(paths.up(row.ravel()), dtype=np.int64)
        rows = np.concatenate([np.arange(a.start[s], a.start[s + 1]) for s in reached])
        made, left = np.empty((len(rows), number + number % 2)), np.empty((0, 2))
        for k in range(0, number, 2):
            own, b, x = row[:, k : k + 2], np.zeros((n, 2)), np.zeros((n, 2))
            np.add.at(b, (own, np.arange(own.shape[1])), value[:, k : k + 2])
            which = np.array(paths.up(own.ravel()), dtype=np.int64)
            kernels.forward_two(values, a, paths.undivided, which, -1, b, left, x)
            made[:, k : k + 2] = x[rows]
        return made[:, :number]

    @cached_property
    def _of_blocks(self) -> Elimination:
        return Elimination(kernels.doubled(self._scalar.analysed, *self._pattern))

    def of_blocks(self, system: Symmetric) -> Factored | None:
        if system.size > 2 * BLOCKS_UP_TO or not memory.fits(4 * self._scalar.bytes):
            return None
        indptr, _, block = system.blocks
        data = block.copy()
        data[indptr[:-1], ::3] *= 2  # half the diagonal is kept
        return Factored(self.name, True, self._of_blocks.solve(data.ravel()))

    def preconditioner(self, lower: sparse.csc_array, *, rough: bool = False) -> Factored:
        if not rough or lower.shape[0] < SINGLE_FROM:
            return self.factor(lower)
        try:
            solve = self._solve(lower, np.float32)
        except NotPositiveDefiniteError:  # a pivot has no digits left
            return self.factor(lower)
        return Factored(f"{self.name} in single precision", False, solve, single=True)

    def for_one_solve(self, lower: sparse.csc_array) -> Factored:
        rough = self.preconditioner(lower, rough=lower.shape[0] >= REFINED_FROM)
        return replace(rough, solve=partial(_refined, lower, rough.solve)) if rough.single else rough

    def _solve(self, lower: sparse.csc_array, precision: Precision = np.float64) -> Inverse:
        if not all(map(np.array_equal, self._pattern, (lower.indptr, lower.indices))):
            return Compiled(lower)._solve(lower, precision)
        return self._scalar.solve(lower.data, precision)


def _refined(lower: sparse.csc_array, rough: Solve, b: FloatArray) -> FloatArray:
    """To the digits of double precision, by conjugate gradients for both columns of b, (n, 2), at once."""

    def product(x: FloatArray) -> FloatArray:
        return kernels.product_with_pairs(lower.indptr, lower.indices, lower.data, x.reshape(b.shape)).ravel()

    def precondition(x: FloatArray) -> FloatArray:
        return rough(x.reshape(b.shape)).ravel()

    x, _, converged = conjugate_gradients(product, b.ravel(), precondition, ALL_DIGITS, MOST_TO_REFINE)
    if not converged[0]:
        raise NotConvergedError
    return x.reshape(b.shape)


def _solved(values: FloatArray, a: kernels.Supernodes, divided: Divided, b: FloatArray) -> FloatArray:
    """For right-hand sides (n,) or (n, k)."""
    sides = b.size // max(len(b), 1)
    if not sides:  # no vertex is inside, or nothing is asked
        return np.empty(b.shape)
    together = TOGETHER if sides >= MANY else 2
    if sides > together:
        each = range(0, sides, together)
        return np.hstack([_solved(values, a, divided, b[:, k : k + together]) for k in each])
    to_below, from_below = WAYS.get(sides, (kernels.forward_many, kernels.backward_many))
    own = np.ascontiguousarray(b if sides > 1 else b.ravel())
    x, made = unfilled(own.shape, values.dtype), unfilled(own.shape)
    x[:] = 0.0
    left = np.empty((divided.parts.rows[-1], *own.shape[1:]), values.dtype)

    def forward(chosen: tuple[IntArray, int]) -> None:
        to_below(values, a, divided.parts, *chosen, own, left, x)

    def backward(chosen: tuple[IntArray, int]) -> None:
        from_below(values, a, divided.parts, *chosen, x, made)

    at_once(forward, divided.subtrees)
    forward((divided.rest, -1))
    backward((divided.rest, -1))
    at_once(backward, divided.subtrees)
    return made.reshape(b.shape)
