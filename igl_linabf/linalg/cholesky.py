"""The Cholesky factor of the compiled core: by supernodes, by as many threads as there are cores."""

import numpy as np

from .. import _core
from .._types import FloatArray, IntArray
from .factors import Analysis, Factor, NotPositiveDefiniteError


class Cholesky(Analysis):
    """The core's symbolic analysis of P A P^T = L L^T, ordered by minimum degree."""

    name = "supernodal Cholesky"

    def __init__(self, indptr: IntArray, indices: IntArray, block: int = 1) -> None:
        self._symbolic = _core.Symbolic(indptr, indices, block)

    @property
    def bytes(self) -> int:
        """What a factor takes."""
        return self._symbolic.bytes

    def factor(self, values: FloatArray) -> Factor:
        made = self._symbolic.factor(np.asarray(values, dtype=np.float64))
        if made.bad_row >= 0:
            raise NotPositiveDefiniteError(made.bad_row)
        return Factor(self.name, made.solve)
