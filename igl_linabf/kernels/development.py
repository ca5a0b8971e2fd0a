"""Triangles of known angles placed one after another in the plane."""

import numpy as np

from .._types import BoolArray, ComplexArray, FloatArray, IntArray
from .choice import with_loops
from .triangles import NEXT, PREV


def _developed(
    z: ComplexArray, known: BoolArray, start: IntArray, twin: IntArray, corner: IntArray, cot: FloatArray
) -> tuple[ComplexArray, float]:
    m = corner.shape[1]
    made, placed, seen = z.copy(), known.copy(), np.zeros(m, dtype=np.bool_)
    queue = np.empty(len(start) + 2 * m, dtype=np.int64)
    sides = np.empty(len(queue), dtype=np.complex128)
    for at in range(len(start)):
        k, t = start[at] // m, start[at] % m
        queue[at] = start[at]
        sides[at] = made[corner[(k + 2) % 3, t]] - made[corner[(k + 1) % 3, t]]
    at, end, worst = 0, len(start), 0.0
    while at < end:
        k, t, side = queue[at] // m, queue[at] % m, sides[at]
        at += 1
        if seen[t]:
            continue
        seen[t] = True
        i, j = (k + 1) % 3, (k + 2) % 3
        apex, tail = corner[k, t], made[corner[i, t]]
        rise = 1 / (cot[i, t] + cot[j, t])
        u, v = cot[i, t] * rise, rise
        x, y = side.real * u - side.imag * v, side.real * v + side.imag * u
        to = complex(x, y)
        there, rest = tail + to, to - side
        if placed[apex]:
            off = there - made[apex]
            short = min(side.real**2 + side.imag**2, x * x + y * y, rest.real**2 + rest.imag**2)
            share = (off.real**2 + off.imag**2) / short
            if not share <= worst:
                worst = share if share > worst else np.inf
        else:
            made[apex], placed[apex] = there, True
        if twin[i * m + t] >= 0:
            queue[end], sides[end] = twin[i * m + t], -rest
            end += 1
        if twin[j * m + t] >= 0:
            queue[end], sides[end] = twin[j * m + t], to
            end += 1
    return made, np.sqrt(worst)


@with_loops(_developed)
def developed(
    z: ComplexArray, known: BoolArray, start: IntArray, twin: IntArray, corner: IntArray, cot: FloatArray
) -> tuple[ComplexArray, float]:
    """The vertices that are not `known` placed triangle after triangle over a breadth-first tree.

    Sides come from angles, not from positions: errors of these would grow from triangle to triangle.

    Parameters
    ----------
    z : (#V,) complex128
        Positions of the known ones.
    known : (#V,) bool
    start : (#s,) int64
        Half-edges k #F + t, opposite to corner k of triangle t, from whose known ends the triangles begin.
    twin : (3 #F,) int64
        The half-edge on the other side of each; -1 at the boundary.
    corner : (3, #F) int64
    cot : (3, #F) float64
        Cotangents of the angles.

    Returns
    -------
    z : (#V,) complex128
    misfit : float
        Where all corners of a triangle lay already, how far one is from where it would be placed, over the
        shortest side: the largest.
    """
    m = corner.shape[1]
    made, placed, seen, worst = z.copy(), known.copy(), np.zeros(m, dtype=bool), 0.0
    k, t = np.divmod(start, m)
    side = made[corner[np.array(PREV)[k], t]] - made[corner[np.array(NEXT)[k], t]]
    while len(start):
        k, t = np.divmod(start, m)
        first = np.sort(np.unique(t, return_index=True)[1])
        first = first[~seen[t[first]]]
        t, k, side = t[first], k[first], side[first]
        seen[t] = True
        i, j = np.array(NEXT)[k], np.array(PREV)[k]
        apex, tail = corner[k, t], made[corner[i, t]]
        to = side * ((cot[i, t] + 1j) / (cot[i, t] + cot[j, t]))
        at, new = np.unique(apex, return_index=True)
        new = new[~placed[at]]
        made[apex[new]], placed[apex[new]] = tail[new] + to[new], True
        with np.errstate(divide="ignore", invalid="ignore"):
            short = np.minimum(np.minimum(abs(side), abs(to)), abs(to - side))
            share = np.delete(abs(tail + to - made[apex]) / short, new)
        worst = max(worst, float(np.nan_to_num(share, nan=np.inf).max(initial=0.0)))
        start = twin[np.stack((i * m + t, j * m + t), axis=1).ravel()]
        side = np.stack((side - to, to), axis=1).ravel()[start >= 0]
        start = start[start >= 0]
    return made, worst
