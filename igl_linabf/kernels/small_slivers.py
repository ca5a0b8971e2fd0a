"""Slivers of small disks, where the conformal metric is far from the paper's: loops only, for numba.

There the preconditioner of conjugate gradients is corrected by the inverse of S on the rows of slivers,
before and after it (Schwarz), as `angles.preconditioner` does it without numba.
"""

import numpy as np

from .._types import BoolArray
from .choice import inlined
from .cholesky import _analysed, _factored
from .small_systems import Fans, Slivers, _fan_add, _fan_errors


@inlined
def _at_slivers(fans: Fans, sliver: BoolArray) -> tuple[bool, Slivers]:
    """S at the rows that are `sliver`, (#rows + 1,), factored; and whether that could be."""
    row, pair, cot = fans
    own, place = np.flatnonzero(sliver), np.full(len(sliver), -1)
    for i in range(len(own)):
        place[own[i]] = i
    beside = np.empty(len(row[0]), dtype=np.bool_)
    for t in range(len(beside)):
        beside[t] = sliver[row[0, t]] or sliver[row[1, t]] or sliver[row[2, t]]
    near, size = np.flatnonzero(beside), 0
    ends, data = np.empty((2, 15 * len(near)), dtype=np.int64), np.empty(15 * len(near))
    diagonal, corner = np.zeros(2 * len(own)), np.empty((3, 1), dtype=np.uint32)
    at, of_one, cot_of_one = np.zeros((3, 4)), np.empty((3, 1)), np.empty((3, 1))
    for i in range(len(near)):
        t = near[i]
        for k in range(3):
            corner[k, 0], of_one[k, 0], cot_of_one[k, 0] = k, pair[k, t], cot[k, t]
        for c in range(6):  # a column of M P M^T of this triangle
            column = 2 * place[row[c // 2, t]] + c % 2
            if column < 0:
                continue
            at[:] = 0.0
            at[c // 2, c % 2] = 1.0
            u, v, w = _fan_errors(0, corner, of_one, cot_of_one, at, 0)
            _fan_add(0, corner, cot_of_one, u, v, w, at, 2)
            diagonal[column] += at[c // 2, 2 + c % 2]
            for d in range(c):
                other = 2 * place[row[d // 2, t]] + d % 2
                if other >= 0:
                    ends[0, size], ends[1, size], data[size] = other, column, at[d // 2, 2 + d % 2]
                    size += 1
    symbolic = _analysed(np.array([0, 2 * len(own)]), ends[:, :size].copy(), np.array([0, size]))
    bad, entries, inverse = _factored(data, diagonal, *symbolic)
    return bad < 0, (near, own, (symbolic[0], symbolic[1], symbolic[2], entries, inverse))
