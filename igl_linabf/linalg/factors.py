"""Sparse symmetric systems: factorisations that keep their analysis, multigrid, conjugate gradients.

CHOLMOD (scikit-sparse) where it is installed; where it is not, PyAMG's smoothed aggregation
preconditions and SciPy's SuperLU factors.
"""

from __future__ import annotations

import os
import warnings
from collections.abc import Callable
from functools import cache
from typing import Any, Literal, Protocol

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse import linalg

from ..errors import FallbackWarning, MeshError, stack_level
from ..surface import FloatArray, IntArray
from . import memory

try:
    from sksparse import cholmod
except ImportError:
    cholmod = None

Array = NDArray[Any]  # float64 or complex128
SolverName = Literal["auto", "cholmod", "multigrid", "direct"]

SIMPLICIAL_UP_TO = 60_000  # rows; supernodal CHOLMOD with a good BLAS is faster above
METIS_FROM = 150_000  # rows; AMD's larger fill costs less than METIS's analysis below
MULTIGRID_RTOL = 1e-10  # where multigrid stands in for a factorisation
MAX_CG_STEPS = 300  # conjugate gradient steps before a factorisation is the better way


def has_cholmod() -> bool:
    """Whether scikit-sparse is installed."""
    return cholmod is not None


class NotPositiveDefiniteError(ArithmeticError):
    """The matrix is singular or indefinite in double precision; `row` has the first bad pivot."""

    def __init__(self, row: int) -> None:
        super().__init__(f"the matrix is not positive definite in double precision (row {row})")
        self.row = row


class NotConvergedError(ArithmeticError):
    """Conjugate gradients did not reach their tolerance within the cap."""


class Factor(Protocol):
    """A way to solve with any matrix of one pattern, once its values are there.

    `exact` says whether `solve` is a factorisation's, or one to `MULTIGRID_RTOL`.
    """

    name: str
    exact: bool

    def factor(self, lower: sparse.csc_array) -> None:
        """Take the values of a Hermitian positive definite matrix from its lower triangle."""

    def solve(self, b: Array) -> Array:
        """Solve for one (n,) or several (n, k) right-hand sides."""

    def precondition(self, b: Array) -> Array:
        """A symmetric positive definite approximation of `solve`, for (n, k)."""


class Cholmod:
    """CHOLMOD's P A P^T = L D L^H, the symbolic analysis done once."""

    name = "CHOLMOD"
    exact = True

    def __init__(self, lower: sparse.csc_array) -> None:
        n = lower.shape[0]
        self._supernodal = n > SIMPLICIAL_UP_TO
        if self._supernodal:
            warn_of_slow_blas()
        self._symbolic = cholmod.analyze(
            lower,
            mode="supernodal" if self._supernodal else "simplicial",
            ordering_method="amd" if n < METIS_FROM else "metis",
        )

    def factor(self, lower: sparse.csc_array) -> None:
        self._numeric = self._symbolic.copy()
        self._unpacked = not self._supernodal
        try:
            self._numeric.cholesky_inplace(lower)
        except cholmod.CholmodNotPositiveDefiniteError as error:
            raise NotPositiveDefiniteError(int(self._symbolic.P()[error.column])) from None
        # the simplicial L D L^H goes on past a negative pivot
        bad = np.flatnonzero(~(self._numeric.D().real > 0))
        if len(bad):
            raise NotPositiveDefiniteError(int(self._symbolic.P()[bad[0]]))

    def solve(self, b: Array) -> Array:
        return np.asarray(self._numeric.solve_A(b))

    def precondition(self, b: Array) -> Array:
        if not self._unpacked:
            # this call leaves the factor in simplicial form, in which a solve takes half the
            # time; unpacking costs about one solve
            self._numeric.solve_LD(np.zeros(len(b)))
            self._unpacked = True
        return self.solve(b)


class SuperLU:
    """SciPy's SuperLU in its symmetric mode, the ordering found once."""

    name = "SuperLU"
    exact = True

    def __init__(self, lower: sparse.csc_array) -> None:
        self._found: IntArray | None = None

    def factor(self, lower: sparse.csc_array) -> None:
        full = mirrored(lower)
        order = self._order = self._found
        try:
            self._lu = linalg.splu(
                full if order is None else full[order][:, order].tocsc(),
                permc_spec="MMD_AT_PLUS_A" if order is None else "NATURAL",
                diag_pivot_thresh=0.0,
                options={"SymmetricMode": True},
            )
        except RuntimeError:  # "Factor is exactly singular", without a place
            raise NotPositiveDefiniteError(0) from None
        rows = self._found = np.argsort(self._lu.perm_c) if order is None else order
        bad = np.flatnonzero(~(self._lu.U.diagonal().real > 0))
        if len(bad):
            raise NotPositiveDefiniteError(int(rows[bad[0]]))

    def solve(self, b: Array) -> Array:
        if self._order is None:
            return np.asarray(self._lu.solve(b))
        x = np.empty_like(b)
        x[self._order] = self._lu.solve(b[self._order])
        return x

    precondition = solve


class Multigrid:
    """PyAMG's smoothed aggregation: one V-cycle as the preconditioner, O(n) memory."""

    name = "PyAMG"
    exact = False

    def __init__(self, lower: sparse.csc_array) -> None:
        pass

    def factor(self, lower: sparse.csc_array) -> None:
        import pyamg

        self._full = sparse.csr_matrix(mirrored(lower))
        # omega by local rows, as the default estimates a spectral radius from random vectors
        self._hierarchy = pyamg.smoothed_aggregation_solver(
            self._full,
            symmetry="symmetric",
            smooth=("jacobi", {"omega": 4 / 3, "weighting": "local"}),
            improve_candidates=None,
            presmoother=("gauss_seidel", {"sweep": "symmetric"}),
            postsmoother=("gauss_seidel", {"sweep": "symmetric"}),
        )
        self._cycle = self._hierarchy.aspreconditioner(cycle="V")

    def solve(self, b: Array) -> Array:
        columns = b.reshape(len(b), -1).T
        x = np.empty_like(columns)
        for k, column in enumerate(columns):
            x[k], _, converged = conjugate_gradients(self._full, column, self._cycle.matvec, MULTIGRID_RTOL)
            if not converged:
                raise NotConvergedError
        return np.ascontiguousarray(x.T).reshape(b.shape)

    def precondition(self, b: Array) -> Array:
        return np.column_stack([self._cycle.matvec(column) for column in b.T])


def mirrored(lower: sparse.csc_array) -> sparse.csc_array:
    """The whole Hermitian matrix of which `lower` is the lower triangle."""
    return (lower + sparse.tril(lower, -1).conj().T).tocsc()


def conjugate_gradients(
    A: Any,
    b: FloatArray,
    precondition: Callable[[FloatArray], FloatArray],
    rtol: float,
    most: int = MAX_CG_STEPS,
) -> tuple[FloatArray, int, bool]:
    """Solve A x = b to |A x - b| <= rtol |b|; returns x, the steps taken and whether it got there."""
    steps = 0

    def count(_: FloatArray) -> None:
        nonlocal steps
        steps += 1

    M = linalg.LinearOperator(A.shape, matvec=precondition, dtype=np.float64)
    x, info = linalg.cg(A, b, rtol=rtol, atol=0.0, maxiter=most, M=M, callback=count)
    return x, steps, info == 0 and bool(np.isfinite(x).all())


class Solvers:
    """Which implementations a computation uses.

    Parameters
    ----------
    solver : {"auto", "cholmod", "multigrid", "direct"}
        "cholmod" and "multigrid" precondition conjugate gradients by a CHOLMOD factor or a PyAMG
        V-cycle; "auto" is the first of them where scikit-sparse is installed; "direct" factors
        the whole system, with CHOLMOD where it is there.
    """

    def __init__(self, solver: SolverName = "auto") -> None:
        if solver not in ("auto", "cholmod", "multigrid", "direct"):
            raise ValueError(f"solver is {solver!r}: use 'auto', 'cholmod', 'multigrid' or 'direct'")
        if solver == "cholmod" and cholmod is None:
            raise ImportError(f"solver='cholmod' needs scikit-sparse, which is not installed: {HOW_TO_GET}")
        if cholmod is None and solver != "multigrid":
            warn_of_missing_cholmod()
        self.direct = solver == "direct"
        self._cholmod = cholmod is not None and solver != "multigrid"

    def laplacian(self, lower: sparse.csc_array) -> Factor:
        """For the scalar Laplacians: the preconditioner and the harmonic layout."""
        if self._cholmod:
            wanted = _bytes_of(lower)
            if self.direct or memory.fits(wanted):
                return Cholmod(lower)
            warnings.warn(
                f"CHOLMOD's factor of {lower.shape[0]:,} rows would take about {memory.gigabytes(wanted)} of "
                "memory, which are not free: multigrid is used instead",
                FallbackWarning,
                stacklevel=stack_level(),
            )
            self._cholmod = False
            multigrid = Multigrid(lower)
            multigrid.name += ", for want of memory"
            return multigrid
        return SuperLU(lower) if self.direct else Multigrid(lower)

    def whole(self, lower: sparse.csc_array) -> Factor:
        """For systems that are factored as a whole.

        Raises
        ------
        MeshError
            The factor would not fit into memory.
        """
        wanted = _bytes_of(lower)
        if not memory.fits(wanted):
            raise MeshError(
                f"the factor of a system of {lower.shape[0]:,} rows would take about "
                f"{memory.gigabytes(wanted)} of memory, which are not free: decimate the mesh (igl.qslim), "
                "cut it into parts (igl_linabf.cut), or use a machine with more memory"
            )
        return Cholmod(lower) if self._cholmod else SuperLU(lower)


def _bytes_of(lower: sparse.csc_array) -> int:
    """What the factor takes; a system with two rows a vertex has four times the entries of half its rows."""
    rows, entries = lower.shape[0], lower.nnz
    block = 2 if entries > 5 * rows else 1  # a planar Laplacian's lower triangle has up to 4 in each row
    return block**2 * memory.factor_bytes(rows // block, lower.dtype.itemsize)


HOW_TO_GET = (
    "install SuiteSparse (Debian: apt install libsuitesparse-dev libopenblas0-pthread; macOS: brew install "
    "suite-sparse; conda: conda install scikit-sparse) and then pip install 'igl-linabf[cholmod]'"
)


@cache
def warn_of_missing_cholmod() -> None:
    """Say once that CHOLMOD is absent, and how to get it."""
    warnings.warn(
        "scikit-sparse is not installed: PyAMG and SciPy's SuperLU are used instead of CHOLMOD, with the "
        f"same results in two to four times the time. To get it, {HOW_TO_GET}",
        FallbackWarning,
        stacklevel=stack_level(),
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
    if cholmod is None or not os.path.exists("/proc/self/maps"):
        return None
    with open("/proc/self/maps") as maps:
        loaded = {line.split()[-1] for line in maps if line.count("/") > 1}
    # NumPy and SciPy bring an OpenBLAS of their own, libscipy_openblas
    for path in sorted(loaded):
        name = os.path.basename(path)
        if name.startswith(("libopenblas", "libmkl_rt", "libblis", "libflexiblas", "libblas.so")):
            fast = any(word in path for word in ("openblas", "mkl", "blis", "flexiblas", "atlas"))
            return path if fast else f"reference BLAS ({path})"
    return None
