"""The steps of conjugate gradients; of vectors made of blocks, too, for many systems at once."""

import numpy as np

from .._runtime import at_once
from .._types import FloatArray, IntArray
from .choice import instead, pieces_of, run, with_loops


def _dot(a: FloatArray, b: FloatArray) -> float:
    total = 0.0
    for i in range(len(a)):
        total += a[i] * b[i]
    return total


def _dot_in_threads(a: FloatArray, b: FloatArray) -> float:
    pieces = [slice(*piece) for piece in pieces_of(len(a))]
    return sum(at_once(lambda piece: run(_dot, a[piece], b[piece]), pieces))


@instead(_dot_in_threads, _dot)
def dot(a: FloatArray, b: FloatArray) -> float:
    """The scalar product of two vectors."""
    return float(np.einsum("i,i->", a, b))


def _turn(d: FloatArray, share: float, z: FloatArray) -> None:
    for i in range(len(d)):
        d[i] = share * d[i] + z[i]


def _turn_in_threads(d: FloatArray, share: float, z: FloatArray) -> None:
    pieces = [slice(*piece) for piece in pieces_of(len(d))]
    at_once(lambda piece: run(_turn, d[piece], share, z[piece]), pieces)


@instead(_turn_in_threads, _turn)
def turn(d: FloatArray, share: float, z: FloatArray) -> None:
    """Make the direction d the sum of a share of it and z."""
    d *= share
    d += z


def _move(x: FloatArray, r: FloatArray, along: float, d: FloatArray, q: FloatArray) -> float:
    total = 0.0
    for i in range(len(x)):
        x[i] += along * d[i]
        left = r[i] - along * q[i]
        r[i] = left
        total += left * left
    return total


def _move_in_threads(x: FloatArray, r: FloatArray, along: float, d: FloatArray, q: FloatArray) -> float:
    pieces = [slice(*piece) for piece in pieces_of(len(x))]
    return sum(at_once(lambda piece: run(_move, x[piece], r[piece], along, d[piece], q[piece]), pieces))


@instead(_move_in_threads, _move)
def move(x: FloatArray, r: FloatArray, along: float, d: FloatArray, q: FloatArray) -> float:
    """Add a share of the direction d to x, and take it of q = A d from the residual r; return r . r."""
    x += along * d
    r -= along * q
    return float(np.einsum("i,i->", r, r))


def _go(x: FloatArray, share: float, a: FloatArray, b: FloatArray) -> None:
    for i in range(len(x)):
        x[i] += share * (b[i] - a[i])


def _go_in_threads(x: FloatArray, share: float, a: FloatArray, b: FloatArray) -> None:
    pieces = [slice(*piece) for piece in pieces_of(len(x))]
    at_once(lambda piece: run(_go, x[piece], share, a[piece], b[piece]), pieces)


@instead(_go_in_threads, _go)
def go(x: FloatArray, share: float, a: FloatArray, b: FloatArray) -> None:
    """Add a share of the way from a to b to x."""
    x += share * (b - a)


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
