"""Define type aliases of arrays and of functions on arrays."""

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
BoolArray = NDArray[np.bool_]
ComplexArray = NDArray[np.complex128]
Array = NDArray[Any]  # float64 or complex128
Solve = Callable[[Array], Array]  # multiplies by a matrix or its inverse
