"""Areas and moments of flat maps, several side by side; a map is given by complex positions."""

from __future__ import annotations

import numpy as np

from .._types import Array, ComplexArray, FloatArray, IntArray
from .choice import with_loops


def _signed_double_areas(z: ComplexArray, corner: IntArray) -> FloatArray:
    made = np.empty(corner.shape[1])
    for t in range(len(made)):
        a, b, c = z[corner[0, t]], z[corner[1, t]], z[corner[2, t]]
        u, v = b - a, c - a
        made[t] = u.real * v.imag - u.imag * v.real
    return made


@with_loops(_signed_double_areas)
def signed_double_areas(z: ComplexArray, corner: IntArray) -> FloatArray:
    """Twice the signed area of each face of a flat map (#V,); positive where it is not flipped."""
    a, b, c = z[corner]
    return np.asarray(((b - a).conj() * (c - a)).imag)


def _first_moments(z: ComplexArray, corner: IntArray, double: FloatArray, start: IntArray) -> ComplexArray:
    made = np.zeros(len(start) - 1, dtype=np.complex128)
    for k in range(len(made)):
        for t in range(start[k], start[k + 1]):
            made[k] += double[t] * (z[corner[0, t]] + z[corner[1, t]] + z[corner[2, t]]) / 3
    return made


@with_loops(_first_moments)
def first_moments(z: ComplexArray, corner: IntArray, double: FloatArray, start: IntArray) -> ComplexArray:
    """Sum of `double` times the centroid over the faces of each part, `start[k]` to `start[k + 1]`."""
    return _sums(double * z[corner].mean(axis=0), start)


def _sums(values: Array, start: IntArray) -> Array:
    """Sums over the parts, none of which is empty."""
    return np.add.reduceat(values, start[:-1]) if len(start) > 2 else values.sum(keepdims=True)


Moments = tuple[ComplexArray, FloatArray]


def _second_moments(
    z: ComplexArray, corner: IntArray, double: FloatArray, start: IntArray, centre: ComplexArray
) -> Moments:
    second, size = np.zeros(len(centre), dtype=np.complex128), np.zeros(len(centre))
    for k in range(len(centre)):
        for t in range(start[k], start[k + 1]):
            a, b, c = z[corner[0, t]] - centre[k], z[corner[1, t]] - centre[k], z[corner[2, t]] - centre[k]
            s = a + b + c
            second[k] += double[t] * (a * a + b * b + c * c + s * s)
            size[k] += double[t] * (
                a.real * a.real
                + a.imag * a.imag
                + b.real * b.real
                + b.imag * b.imag
                + c.real * c.real
                + c.imag * c.imag
            )
    return second, size


@with_loops(_second_moments)
def second_moments(
    z: ComplexArray, corner: IntArray, double: FloatArray, start: IntArray, centre: ComplexArray
) -> Moments:
    """Of the parts about their centres: sum z^2 over corners and their sum, and sum |z|^2."""
    a, b, c = z[corner] - np.repeat(centre, np.diff(start))
    second = double * (a**2 + b**2 + c**2 + (a + b + c) ** 2)
    size = double * (_squared(a) + _squared(b) + _squared(c))
    return _sums(second, start), _sums(size, start)


def _squared(z: ComplexArray) -> FloatArray:
    return np.asarray(z.real**2 + z.imag**2)


def _third_moments(
    z: ComplexArray,
    corner: IntArray,
    double: FloatArray,
    start: IntArray,
    centre: ComplexArray,
    turn: ComplexArray,
) -> FloatArray:
    made = np.zeros(len(centre))
    for k in range(len(centre)):
        for t in range(start[k], start[k + 1]):
            s = (z[corner[0, t]] + z[corner[1, t]] + z[corner[2, t]]) / 3 - centre[k]
            x = (s * turn[k]).real
            made[k] += double[t] * x * x * x
    return made


@with_loops(_third_moments)
def third_moments(
    z: ComplexArray,
    corner: IntArray,
    double: FloatArray,
    start: IntArray,
    centre: ComplexArray,
    turn: ComplexArray,
) -> FloatArray:
    """Sum of `double` times the cube of the turned centroid's real part, about the centres of the parts."""
    sizes = np.diff(start)
    a, b, c = z[corner] - np.repeat(centre, sizes)
    x = ((a + b + c) / 3 * np.repeat(turn, sizes)).real
    return _sums(double * (x * x * x), start)  # a power takes ten times as long
