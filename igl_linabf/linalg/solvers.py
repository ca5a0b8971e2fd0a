"""Choose the Cholesky factorization: the core's by default, or CHOLMOD on request."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np
from scipy import sparse

from .._types import IntArray
from ..errors import MemoryLimitError
from . import memory
from .cholmod import CHOLMOD_INSTALL_HINT, Cholmod, has_cholmod
from .factors import Analysis, Cholesky, Factor, to_real_form

SolverName = Literal["auto", "cholmod", "direct"]


@dataclass(frozen=True)
class Solvers:
    """The choice of the linear solvers that a computation uses.

    Parameters
    ----------
    solver : {"auto", "cholmod", "direct"}
        "auto" solves the angle system by conjugate gradients, preconditioned by the core's Cholesky factor of
        a Laplacian; "cholmod" uses a factor by CHOLMOD instead. "direct" factors the whole system with the
        core.
    """

    solver: SolverName = "auto"

    def __post_init__(self) -> None:
        if self.solver not in get_args(SolverName):
            raise ValueError(f"solver is {self.solver!r}: use 'auto', 'cholmod' or 'direct'")
        if self.solver == "cholmod" and not has_cholmod():
            raise ImportError(
                f"solver='cholmod' needs scikit-sparse, which is not installed: {CHOLMOD_INSTALL_HINT}"
            )

    @property
    def allows_shared_factors(self) -> bool:
        """Whether the default solver is used, so that factors of other computations may be reused."""
        return self.solver == "auto"

    def analyse(self, indptr: IntArray, indices: IntArray, block: int = 1) -> Analysis:
        """Analyse the pattern of a matrix over a planar graph.

        The pattern is the lower triangle in CSC, with the diagonal entry first in each column. If `block` is
        2, each entry represents a 2 by 2 block.

        Raises
        ------
        MemoryLimitError
            The factor would not fit into memory.
        """
        rows = len(indptr) - 1
        wanted = memory.factor_bytes(rows, block)
        if not memory.has_free_memory(wanted):
            raise MemoryLimitError(
                f"the factor of a system of {block * rows:,} rows would take about "
                f"{memory.format_gigabytes(wanted)} of memory, which are not free: decimate the mesh "
                "(igl.qslim), cut it into parts (igl_linabf.cut), or use a machine with more memory"
            )
        made = Cholmod if self.solver == "cholmod" else Cholesky
        return made(indptr, indices, block)

    def factor(self, lower: sparse.csc_array) -> Factor:
        """Analyse and factor a matrix given by its lower triangle; a complex matrix in its `to_real_form`.

        Raises
        ------
        MemoryLimitError, NotPositiveDefiniteError
        """
        if np.iscomplexobj(lower.data):
            return self.analyse(lower.indptr, lower.indices, 2).factor(to_real_form(lower.data))
        return self.analyse(lower.indptr, lower.indices).factor(lower.data)
