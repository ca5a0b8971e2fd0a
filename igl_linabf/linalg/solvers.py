"""Which factor a system gets: the core's, or CHOLMOD's where that is asked for."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np
from scipy import sparse

from .._types import IntArray
from ..errors import MemoryLimitError
from . import memory
from .cholmod import HOW_TO_GET, Cholmod, has_cholmod
from .factors import Analysis, Cholesky, Factor, real_form

SolverName = Literal["auto", "cholmod", "direct"]


@dataclass(frozen=True)
class Solvers:
    """Which implementations a computation uses.

    Parameters
    ----------
    solver : {"auto", "cholmod", "direct"}
        "auto" solves the angle system by conjugate gradients, preconditioned by the core's Cholesky factor of
        a Laplacian; "cholmod" by CHOLMOD's. "direct" factors the whole system, by the core.
    """

    solver: SolverName = "auto"

    def __post_init__(self) -> None:
        if self.solver not in get_args(SolverName):
            raise ValueError(f"solver is {self.solver!r}: use 'auto', 'cholmod' or 'direct'")
        if self.solver == "cholmod" and not has_cholmod():
            raise ImportError(f"solver='cholmod' needs scikit-sparse, which is not installed: {HOW_TO_GET}")

    @property
    def shared(self) -> bool:
        """Whether a factor that was made elsewhere serves as well: no other implementation is asked for."""
        return self.solver == "auto"

    def analyse(self, indptr: IntArray, indices: IntArray, block: int = 1) -> Analysis:
        """Analyse the lower triangle of a planar graph's matrix in CSC, the diagonal first in each column.

        With `block` 2, each of its entries stands for a 2 by 2 block.

        Raises
        ------
        MemoryLimitError
            The factor would not fit into memory.
        """
        rows = len(indptr) - 1
        wanted = memory.factor_bytes(rows, block)
        if not memory.fits(wanted):
            raise MemoryLimitError(
                f"the factor of a system of {block * rows:,} rows would take about "
                f"{memory.gigabytes(wanted)} of memory, which are not free: decimate the mesh (igl.qslim), "
                "cut it into parts (igl_linabf.cut), or use a machine with more memory"
            )
        made = Cholmod if self.solver == "cholmod" else Cholesky
        return made(indptr, indices, block)

    def factor(self, lower: sparse.csc_array) -> Factor:
        """Factor a matrix, given by its lower triangle, once; of a complex one, its `real_form`.

        Raises
        ------
        MemoryLimitError, NotPositiveDefiniteError
        """
        if np.iscomplexobj(lower.data):
            return self.analyse(lower.indptr, lower.indices, 2).factor(real_form(lower.data))
        return self.analyse(lower.indptr, lower.indices).factor(lower.data)
