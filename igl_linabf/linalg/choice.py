"""Which solver a system gets: decided once by what is installed, and for each system by its size."""

import os
import warnings
from dataclasses import dataclass
from functools import cache
from typing import Literal, get_args

import numpy as np
from scipy import sparse

from ..errors import FallbackWarning, MemoryLimitError, stack_level
from ..kernels import is_fast
from . import memory
from .compiled import Compiled
from .factors import SIMPLICIAL_UP_TO, Analysis, Cholmod, IglCholesky, has_cholmod
from .multigrid import Multigrid
from .small_blocks import SmallBlocks

SolverName = Literal["auto", "cholmod", "multigrid", "direct"]

SUPERNODAL_FROM = 10_000  # rows of what is factored often: with a good BLAS this takes a third of the time
MULTIGRID_FROM = 80_000  # rows, where there is no CHOLMOD: a simplicial factor takes longer


@dataclass(frozen=True)
class Solvers:
    """Which implementations a computation uses.

    Parameters
    ----------
    solver : {"auto", "cholmod", "multigrid", "direct"}
        "cholmod" and "multigrid" precondition conjugate gradients by a CHOLMOD factor or a PyAMG
        V-cycle. "auto" is a Cholesky factor by compiled loops where numba is installed, or else
        "cholmod" where scikit-sparse is. Without either, it is the Cholesky factor of libigl's
        wheel, and multigrid from `MULTIGRID_FROM` rows on. "direct" factors the whole system.
    """

    solver: SolverName = "auto"

    def __post_init__(self) -> None:
        if self.solver not in get_args(SolverName):
            raise ValueError(f"solver is {self.solver!r}: use 'auto', 'cholmod', 'multigrid' or 'direct'")
        if self.solver == "cholmod" and not has_cholmod():
            raise ImportError(f"solver='cholmod' needs scikit-sparse, which is not installed: {HOW_TO_GET}")

    @property
    def direct(self) -> bool:
        """Whether the angle system is factored as a whole."""
        return self.solver == "direct"

    @property
    def compiled(self) -> bool:
        """Whether Laplacians are factored by compiled loops, if there is memory."""
        return self.solver == "auto" and is_fast()

    @property
    def shared(self) -> bool:
        """Whether factors that were made for other purposes do as well."""
        return self.solver == "auto"

    def laplacian(self, lower: sparse.csc_array, small: bool = False) -> Analysis:
        """For the scalar Laplacians: the preconditioner and the harmonic layout; `small`: of small meshes."""
        compiled = self.compiled
        if compiled and small:
            return SmallBlocks(lower)
        n, wanted = lower.shape[0], _bytes_of(lower)
        slow = self.solver == "auto" and not compiled and not has_cholmod()
        if self.solver == "multigrid" or (slow and n >= MULTIGRID_FROM):
            return Multigrid()
        if self.direct or memory.fits(wanted):
            if compiled and lower.dtype == np.float64:
                return Compiled(lower)
            return self._factoring(lower)
        warnings.warn(
            f"the factor of {n:,} rows would take about {memory.gigabytes(wanted)} of "
            "memory, which are not free: multigrid is used instead",
            FallbackWarning,
            stacklevel=stack_level(),
        )
        return Multigrid("PyAMG, for want of memory")

    def whole(self, lower: sparse.csc_array, *, often: bool = False) -> Analysis:
        """For systems that are factored as a whole; `often`: time and again.

        Raises
        ------
        MemoryLimitError
            The factor would not fit into memory.
        """
        wanted = _bytes_of(lower)
        if not memory.fits(wanted):
            raise MemoryLimitError(
                f"the factor of a system of {lower.shape[0]:,} rows would take about "
                f"{memory.gigabytes(wanted)} of memory, which are not free: decimate the mesh (igl.qslim), "
                "cut it into parts (igl_linabf.cut), or use a machine with more memory"
            )
        if often and self.compiled and lower.dtype == np.float64:
            return Compiled(lower)
        return self._factoring(lower)

    def _factoring(self, lower: sparse.csc_array) -> Analysis:
        if has_cholmod() and self.solver != "multigrid":
            return _cholmod(lower)
        return IglCholesky(lower)


def _cholmod(lower: sparse.csc_array) -> Cholmod:
    if lower.shape[0] > SIMPLICIAL_UP_TO:
        warn_of_slow_blas()
    return Cholmod(lower)


def _bytes_of(lower: sparse.csc_array) -> int:
    """What the factor takes; a system with two rows a vertex has four times the entries of half its rows."""
    rows, entries = lower.shape[0], lower.nnz
    block = 2 if entries > 5 * rows else 1  # a planar Laplacian's lower triangle has up to 4 in each row
    return block**2 * memory.factor_bytes(rows // block, lower.dtype.itemsize)


def factored_often(lower: sparse.csc_array) -> Analysis:
    """Of a scalar Laplacian that is factored often, and solved with once each time: what takes least time."""
    analysis = Solvers().laplacian(lower)
    if type(analysis) is Cholmod and lower.shape[0] > SUPERNODAL_FROM and _good_blas():
        return Cholmod(lower, simplicial_up_to=0)
    return analysis


@cache
def _good_blas() -> bool:
    blas = blas_of_cholmod()
    return blas is not None and "reference" not in blas


HOW_TO_GET = (
    "install SuiteSparse (Debian: apt install libsuitesparse-dev libopenblas0-pthread; macOS: brew install "
    "suite-sparse) and then pip install 'igl-linabf[cholmod]'; conda: "
    "conda install -c conda-forge 'scikit-sparse<0.5'"
)


@cache
def warn_of_slow_blas() -> None:
    """Say once that supernodal CHOLMOD runs on the reference BLAS."""
    blas = blas_of_cholmod()
    if blas is not None and "reference" in blas:
        warnings.warn(
            f"CHOLMOD uses the {blas}, three times slower than OpenBLAS on meshes of this size: "
            "install OpenBLAS (Debian: apt install libopenblas0-pthread)",
            FallbackWarning,
            stacklevel=stack_level(),
        )


def blas_of_cholmod() -> str | None:
    """The BLAS that CHOLMOD calls, as far as the loaded libraries tell; None where they do not."""
    if not has_cholmod() or not os.path.exists("/proc/self/maps"):
        return None
    with open("/proc/self/maps", encoding="utf-8") as maps:
        loaded = {line.split()[-1] for line in maps if line.count("/") > 1}
    # NumPy and SciPy bring an OpenBLAS of their own, libscipy_openblas
    for path in sorted(loaded):
        name = os.path.basename(path)
        if name.startswith(("libopenblas", "libmkl_rt", "libblis", "libflexiblas", "libblas.so")):
            fast = any(word in path for word in ("openblas", "mkl", "blis", "flexiblas", "atlas"))
            return path if fast else f"reference BLAS ({path})"
    return None
