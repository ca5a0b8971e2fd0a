"""Sparse linear algebra.

In: Hermitian matrices over a mesh's vertices, by their lower triangles. Out: factors, solutions.
CHOLMOD (Chen et al. 2008), PyAMG's smoothed aggregation (Vanek et al. 1996), SuperLU, conjugate gradients.
"""

from .choice import HOW_TO_GET, SolverName, Solvers, blas_of_cholmod, factored_often
from .factors import Analysis, Factored, NotConvergedError, NotPositiveDefiniteError, SuperLU, has_cholmod
from .krylov import MAX_CG_STEPS, conjugate_gradients
from .memory import check_memory, factor_bytes
from .multigrid import Multigrid
from .small_blocks import SMALL, SmallBlocks
from .some_rows import Rows
from .sparsity import Pattern, Symmetric, held
from .within import Within
