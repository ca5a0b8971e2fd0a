"""Vectors made of blocks, each for itself: the steps of conjugate gradients for many systems at once."""

from __future__ import annotations

import numpy as np

from .._types import FloatArray, IntArray
from .choice import with_loops


def _block_dots(start: IntArray, a: FloatArray, b: FloatArray) -> FloatArray:
    made = np.zeros(len(start) - 1)
    for k in range(len(made)):
        total = 0.0
        for i in range(start[k], start[k + 1]):
            total += a[i] * b[i]
        made[k] = total
    return made


@with_loops(_block_dots)
def block_dots(start: IntArray, a: FloatArray, b: FloatArray) -> FloatArray:
    """Scalar products of the parts of two vectors; part k is `start[k]` to `start[k + 1]`, or empty."""
    made = np.zeros(len(start) - 1)
    filled = np.flatnonzero(np.diff(start))
    if len(filled):
        made[filled] = np.add.reduceat(a * b, start[:-1][filled])
    return made


def _block_axpy(start: IntArray, share: FloatArray, a: FloatArray, b: FloatArray) -> FloatArray:
    made = np.empty_like(a)
    for k in range(len(share)):
        for i in range(start[k], start[k + 1]):
            made[i] = b[i] + share[k] * a[i]
    return made


@with_loops(_block_axpy)
def block_axpy(start: IntArray, share: FloatArray, a: FloatArray, b: FloatArray) -> FloatArray:
    """`b` plus a share of `a`, one share a part."""
    return np.asarray(b + np.repeat(share, np.diff(start)) * a)
