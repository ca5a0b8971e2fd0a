"""How far charts whose vertices stand one after the other reach, and how large they are."""

import numpy as np

from .._types import ComplexArray, FloatArray
from ..surface import Parts


def extents(z: ComplexArray, charts: Parts) -> tuple[ComplexArray, ComplexArray]:
    """Lower left corners of the rectangles around charts, and their extents."""
    low, high = (function(z.real) + 1j * function(z.imag) for function in (charts.min, charts.max))
    return low, high - low


def areas(double: FloatArray, faces: Parts) -> FloatArray:
    """The area of each chart, by twice the signed areas of its faces."""
    return np.asarray(faces.sum(np.abs(double))) / 2
