"""Checks of the shapes of given arrays, with the errors of xatlas-python."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike


def check_shape(name: str, array: ArrayLike, columns: int, rows: int | None = None) -> int:
    """Check the number of columns of an array and, if `rows` is given, of rows; return the number of rows."""
    shape: Sequence[int] = np.shape(array)
    if len(shape) != 2 or shape[1] != columns:
        raise ValueError(f"{name} has the shape {tuple(shape)}: pass an Nx{columns} array")
    if rows is not None and shape[0] != rows:
        raise ValueError(f"{name} has {shape[0]:,} rows in the first dimension: pass {rows}")
    return shape[0]
