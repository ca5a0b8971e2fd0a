"""Areas of flat maps, what they change, and their places on the page."""

import numpy as np

from .._runtime import unfilled
from .._types import Array, ComplexArray, FloatArray, IntArray
from .choice import filled_by, with_loops
from .triangles import NEXT, PREV, _arctangent

SYMMETRIC = 1e-9  # relative moment below which it is of rounding
BESIDE_AXES = np.exp(-0.3j)  # a direction along which no axis of a map is likely to be


def _signed_double_areas(z: ComplexArray, corner: IntArray, first: int, last: int, made: FloatArray) -> None:
    for t in range(first, last):
        a, b, c = z[corner[0, t]], z[corner[1, t]], z[corner[2, t]]
        u, v = b - a, c - a
        made[t] = u.real * v.imag - u.imag * v.real


@filled_by(_signed_double_areas, lambda z, corner: unfilled(corner.shape[1]))
def signed_double_areas(z: ComplexArray, corner: IntArray) -> FloatArray:
    """Twice the signed area of each face of a flat map (#V,); positive where it is not flipped."""
    a, b, c = z[corner]
    return np.asarray(((b - a).conj() * (c - a)).imag)


def _centred(
    z: ComplexArray,
    corner: IntArray,
    double: FloatArray,
    area: FloatArray,
    vertex_start: IntArray,
    face_start: IntArray,
) -> ComplexArray:
    made = np.empty_like(z)
    for i in range(len(area)):
        total, centroid, second, size, third = 0.0, 0j, 0j, 0.0, 0.0
        for t in range(face_start[i], face_start[i + 1]):
            total += double[t]
            centroid += double[t] * (z[corner[0, t]] + z[corner[1, t]] + z[corner[2, t]]) / 3
        centroid /= total
        for t in range(face_start[i], face_start[i + 1]):
            a, b, c = z[corner[0, t]] - centroid, z[corner[1, t]] - centroid, z[corner[2, t]] - centroid
            s = a + b + c
            second += double[t] * (a * a + b * b + c * c + s * s)
            for u in (a, b, c):
                size += double[t] * (u.real * u.real + u.imag * u.imag)
        turn = 1 + 0j
        if abs(second) > SYMMETRIC * size:
            angle = np.arctan2(second.imag, second.real) / 2
            turn = complex(np.cos(angle), -np.sin(angle))
        for t in range(face_start[i], face_start[i + 1]):
            s = (z[corner[0, t]] + z[corner[1, t]] + z[corner[2, t]]) / 3 - centroid
            x = (s * turn).real
            third += double[t] * x * x * x
        if not abs(third) > SYMMETRIC * total * (size / total) ** 1.5:
            third = (turn * BESIDE_AXES).real
        turn *= np.sqrt(2 * area[i] / total) * (-1 if third < 0 else 1)
        for v in range(vertex_start[i], vertex_start[i + 1]):
            made[v] = (z[v] - centroid) * turn
    return made


@with_loops(_centred)
def centred(
    z: ComplexArray,
    corner: IntArray,
    double: FloatArray,
    area: FloatArray,
    vertex_start: IntArray,
    face_start: IntArray,
) -> ComplexArray:
    """Maps side by side, each scaled to its area, its centroid at 0 and its principal axes along x and y.

    `double` is twice the area of each face. Map i has the vertices `vertex_start[i]` up to
    `vertex_start[i + 1]`, and such faces. The longer axis is x; of its two directions the one that gives a
    positive third moment. A symmetric map, of which rounding would choose the axes or a direction, is turned
    by a rule that does not depend on rounding.
    """
    sizes = np.diff(face_start)
    total, at = _sums(double, face_start), z[corner]
    centroid = _sums(double * at.mean(axis=0), face_start) / total
    a, b, c = about = at - np.repeat(centroid, sizes)
    second = _sums(double * (a**2 + b**2 + c**2 + (a + b + c) ** 2), face_start)
    size = _sums(double * (about.real**2 + about.imag**2).sum(axis=0), face_start)
    turn = np.exp(-0.5j * np.angle(np.where(np.abs(second) > SYMMETRIC * size, second, 1)))
    x = ((a + b + c) / 3 * np.repeat(turn, sizes)).real
    third = _sums(double * (x * x * x), face_start)  # a power takes ten times as long
    odd = np.abs(third) > SYMMETRIC * total * (size / total) ** 1.5
    turn = np.where(np.where(odd, third, (turn * BESIDE_AXES).real) < 0, -turn, turn)
    turn *= np.sqrt(2 * area / total)
    vertices = np.diff(vertex_start)
    return np.asarray((z - np.repeat(centroid, vertices)) * np.repeat(turn, vertices))


Changes = tuple[FloatArray, FloatArray, FloatArray, FloatArray, FloatArray, FloatArray]


def _changes(V: FloatArray, uv: FloatArray, corner: IntArray, double: FloatArray, dot: FloatArray) -> Changes:
    m = corner.shape[1]
    angle, error, sides = np.empty((3, m)), np.empty((3, m)), np.empty((3, m))
    signed, major, minor = np.empty(m), np.empty(m), np.empty(m)
    right, left = np.empty((3, 2)), np.empty((3, 2))
    for t in range(m):
        length = 0.0
        for k in range(3):
            v, n, p = corner[k, t], corner[(k + 1) % 3, t], corner[(k + 2) % 3, t]
            flat, long = 0.0, 0.0
            for j in range(2):
                right[k, j], left[k, j] = uv[n, j] - uv[v, j], uv[p, j] - uv[v, j]
                flat += (uv[p, j] - uv[n, j]) ** 2
            for j in range(3):
                long += (V[p, j] - V[n, j]) ** 2
            length = np.sqrt(long)
            sides[k, t] = np.sqrt(flat) / length
            cross = right[k, 0] * left[k, 1] - right[k, 1] * left[k, 0]
            angle[k, t] = _arctangent(double[t], dot[k, t])
            along = right[k, 0] * left[k, 0] + right[k, 1] * left[k, 1]
            error[k, t] = _arctangent(abs(cross), along) - angle[k, t]
            if k == 0:
                signed[t] = cross
        a, b = right[0, 0] / length, right[0, 1] / length
        c = (left[0, 0] * length - dot[0, t] * a) / double[t]
        d = (left[0, 1] * length - dot[0, t] * b) / double[t]
        major[t] = (np.sqrt((a + d) ** 2 + (b - c) ** 2) + np.sqrt((a - d) ** 2 + (b + c) ** 2)) / 2
        minor[t] = abs(a * d - b * c) / major[t] if major[t] > 0 else 0.0
    return angle, error, signed, major, minor, sides


@with_loops(_changes)
def changes(V: FloatArray, uv: FloatArray, corner: IntArray, double: FloatArray, dot: FloatArray) -> Changes:
    """What a flat map (#V, 2) does to each triangle; `double` and `dot` as in a `Mesh`.

    The angles in space, and what they are more in the map, (3, #F) each; twice the signed areas in the map;
    the larger and the smaller singular value; the ratios of the lengths of sides, (3, #F).
    """
    z = (uv[:, 0] + 1j * uv[:, 1])[corner]
    right, left = z[NEXT] - z, z[PREV] - z
    cross = right.conj() * left  # its argument is the angle, its imaginary part twice the area
    angle, error = np.arctan2(double, dot), np.arctan2(np.abs(cross.imag), cross.real)
    error -= angle
    at = V[corner]
    length = np.linalg.norm(at[PREV] - at[NEXT], axis=2)
    # columns of the Jacobian in the frame of side 0-1: right = l c1, left = (dot c1 + 2 A c2) / l
    c1 = right[0] / length[2]
    c2 = (left[0] * length[2] - dot[0] * c1) / double
    p, q = (c1 - 1j * c2) / 2, (c1 + 1j * c2) / 2  # f(w) = p w + q conj(w)
    major = np.abs(p) + np.abs(q)
    with np.errstate(divide="ignore", invalid="ignore"):
        minor = np.where(major > 0, np.abs((c1.conj() * c2).imag) / major, 0.0)
    return angle, error, np.ascontiguousarray(cross[0].imag), major, minor, np.abs(z[PREV] - z[NEXT]) / length


def _sums(values: Array, start: IntArray) -> Array:
    """Sums over the parts, none of which is empty."""
    return np.add.reduceat(values, start[:-1]) if len(start) > 2 else values.sum(keepdims=True)
