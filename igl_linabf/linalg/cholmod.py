"""CHOLMOD (Chen et al. 2008) through scikit-sparse, an optional extra; tests compare the core's to it."""

import os
import warnings
from functools import cache
from importlib.util import find_spec
from typing import Any

import numpy as np
from scipy import sparse

from .._types import FloatArray, IntArray, Solve
from ..errors import FallbackWarning, stack_level
from .constants import SIMPLICIAL_ROWS
from .factors import Analysis, Factor, NotPositiveDefiniteError

HOW_TO_GET = (
    "install SuiteSparse (Debian: apt install libsuitesparse-dev libopenblas0-pthread; macOS: brew install "
    "suite-sparse) and then pip install 'igl-linabf[cholmod]'; conda: "
    "conda install -c conda-forge 'scikit-sparse<0.5'"
)


def has_cholmod() -> bool:
    """Whether scikit-sparse is installed."""
    return find_spec("sksparse") is not None


class Cholmod(Analysis):
    """CHOLMOD's symbolic analysis of P A P^T = L D L^T."""

    name = "CHOLMOD"

    def __init__(self, indptr: IntArray, indices: IntArray, block: int = 1) -> None:
        from sksparse import cholmod

        self._error = cholmod.CholmodNotPositiveDefiniteError
        self._source: IntArray | None = None
        if block > 1:
            indptr, indices, self._source = _entries_of_blocks(indptr, indices, block)
        n = len(indptr) - 1
        self._lower = sparse.csc_matrix((np.ones(len(indices)), indices, indptr), shape=(n, n))
        supernodal = n > SIMPLICIAL_ROWS
        if supernodal:
            _warn_of_slow_blas()
        # METIS's smaller fill never pays for its analysis
        mode = "supernodal" if supernodal else "simplicial"
        self._symbolic = cholmod.analyze(self._lower, mode=mode, ordering_method="amd") if n else None

    def factor(self, values: FloatArray) -> Factor:
        if self._symbolic is None:
            return Factor(self.name, np.copy)
        lower, numeric = self._lower.copy(), self._symbolic.copy()
        lower.data = values if self._source is None else values.ravel()[self._source]
        try:
            numeric.cholesky_inplace(lower)
        except self._error as error:
            raise NotPositiveDefiniteError(int(self._symbolic.P()[error.column])) from None
        bad = np.flatnonzero(~(numeric.D() > 0))  # the simplicial L D L^T goes on past a negative pivot
        if len(bad):
            raise NotPositiveDefiniteError(int(self._symbolic.P()[bad[0]]))
        return Factor(self.name, _solver(numeric))


def _solver(numeric: Any) -> Solve:
    def solve(b: FloatArray) -> FloatArray:
        return np.asarray(numeric.solve_A(b)) if b.size else np.empty(b.shape)

    return solve


def _entries_of_blocks(
    indptr: IntArray, indices: IntArray, block: int
) -> tuple[IntArray, IntArray, IntArray]:
    """The pattern of the entries, and where each of them is among the entries of the blocks."""
    number = np.arange(1, block**2 * len(indices) + 1).reshape(-1, block, block)
    upper = sparse.bsr_array((number, indices, indptr), shape=(block * (len(indptr) - 1),) * 2)
    rows = sparse.triu(upper, format="csr")  # the upper triangle by rows is the lower one by columns
    rows.sort_indices()
    return rows.indptr, rows.indices, rows.data - 1


@cache
def _warn_of_slow_blas() -> None:
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
    from sksparse import cholmod  # noqa: F401, which loads them

    with open("/proc/self/maps", encoding="utf-8") as maps:
        loaded = {line.split()[-1] for line in maps if line.count("/") > 1}
    # NumPy and SciPy bring an OpenBLAS of their own, libscipy_openblas
    for path in sorted(loaded):
        name = os.path.basename(path)
        if name.startswith(("libopenblas", "libmkl_rt", "libblis", "libflexiblas", "libblas.so")):
            fast = any(word in path for word in ("openblas", "mkl", "blis", "flexiblas", "atlas"))
            return path if fast else f"reference BLAS ({path})"
    return None
