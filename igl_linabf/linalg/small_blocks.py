"""The factor of small systems side by side by compiled loops, where the extra `fast` is installed."""

from functools import partial

import numpy as np
from scipy import sparse

from .. import kernels
from .._types import BoolArray, FloatArray
from .factors import Analysis, Factored, NotPositiveDefiniteError, by_pairs_of_columns

SMALL = 3_000  # triangles up to which a mesh's system is small: its ordering takes the square of them


class SmallBlocks(Analysis):
    """The Cholesky factors of the diagonal blocks of a real matrix, each ordered by minimum degree."""

    name = "compiled Cholesky"

    def __init__(self, lower: sparse.csc_array) -> None:
        self._symbolic = kernels.analysed(lower.indptr, lower.indices)

    def numeric(self, lower: sparse.csc_array) -> kernels.Factor:
        """The factors of a matrix, as kernels take them."""
        bad, factor = kernels.factored(self._symbolic, lower.data, lower.data[lower.indptr[:-1]])
        if bad >= 0:
            raise NotPositiveDefiniteError(bad)
        return factor

    def factor(self, lower: sparse.csc_array) -> Factored:
        pair = partial(kernels.solved, self.numeric(lower))
        return Factored(self.name, True, partial(by_pairs_of_columns, pair))

    def solved_inside(self, lower: sparse.csc_array, free: BoolArray, r: FloatArray) -> FloatArray:
        """The x with A x = r in the rows that are `free`, and 0 in the others."""
        bad, x = kernels.solved_inside(
            self._symbolic, lower.indptr, lower.indices, lower.data, free, np.ascontiguousarray(r)
        )
        if bad >= 0:
            raise NotPositiveDefiniteError(bad)
        return x
