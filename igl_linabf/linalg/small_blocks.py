"""The factor of small systems side by side by compiled loops, where the extra `fast` is installed."""

from __future__ import annotations

from functools import partial

import numpy as np
from scipy import sparse

from .. import kernels
from .._types import FloatArray
from .factors import Factored, NotPositiveDefiniteError

SMALL = 3_000  # triangles up to which a mesh's system is small: its ordering takes the square of them


class SmallBlocks:
    """The Cholesky factors of the diagonal blocks of a real matrix, each ordered by minimum degree."""

    name = "compiled Cholesky"

    def __init__(self, lower: sparse.csc_array) -> None:
        self._symbolic = kernels.analysed(lower.indptr, lower.indices)

    def numeric(self, lower: sparse.csc_array) -> kernels.Factor:
        """The factors of a matrix, as kernels take them."""
        bad, factor = kernels.factored(self._symbolic, lower.data)
        if bad >= 0:
            raise NotPositiveDefiniteError(bad)
        return factor

    def factor(self, lower: sparse.csc_array) -> Factored:
        return Factored(self.name, True, self.preconditioner(lower))

    def preconditioner(self, lower: sparse.csc_array) -> partial[FloatArray]:
        return partial(_solved, self.numeric(lower))


def _solved(factor: kernels.Factor, b: FloatArray) -> FloatArray:
    """For one (n,) or several (n, k) right-hand sides."""
    columns = b.reshape(len(b), -1)
    if columns.shape[1] % 2:
        columns = np.column_stack((columns, np.zeros(len(b))))
    pairs = [kernels.solved(factor, columns[:, k : k + 2]) for k in range(0, columns.shape[1], 2)]
    x = pairs[0] if len(pairs) == 1 else np.hstack(pairs)
    return x[:, : b.size // max(len(b), 1)].reshape(b.shape)
