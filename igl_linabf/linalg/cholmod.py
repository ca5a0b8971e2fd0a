"""CHOLMOD (Chen et al. 2008) through scikit-sparse, an optional alternative to the core's Cholesky factor."""

import os
import warnings
from functools import cache
from importlib.util import find_spec

import numpy as np
from scipy import sparse

from .._types import FloatArray, IntArray
from ..errors import FallbackWarning, stack_level
from .factors import Analysis, Factor
from .scikit_sparse import CholmodInterface, select_interface

SIMPLICIAL_ROWS = 25_000  # with more rows, a supernodal factor is faster than a simplicial factor

CHOLMOD_INSTALL_HINT = (
    "install SuiteSparse (Debian: apt install libsuitesparse-dev libopenblas0-pthread; macOS: brew install "
    "suite-sparse) and then pip install 'igl-linabf[cholmod]', with 'scikit-sparse<0.5' if SuiteSparse is "
    "older than version 7; conda: conda install -c conda-forge scikit-sparse"
)


def has_cholmod() -> bool:
    """Return True if scikit-sparse is installed."""
    return find_spec("sksparse") is not None


class Cholmod(Analysis):
    """The symbolic analysis of P A P^T = L D L^T by CHOLMOD."""

    name = "CHOLMOD"

    def __init__(self, indptr: IntArray, indices: IntArray, block: int = 1) -> None:
        from sksparse import cholmod

        self._source: IntArray | None = None
        if block > 1:
            indptr, indices, self._source = _expand_blocks(indptr, indices, block)
        n = len(indptr) - 1
        self._lower = sparse.csc_matrix((np.ones(len(indices)), indices, indptr), shape=(n, n))
        supernodal = n > SIMPLICIAL_ROWS
        if supernodal:
            _warn_of_slow_blas()
        # AMD for all sizes: METIS has less fill, but its analysis takes longer than the fill saves
        mode, analyse = "supernodal" if supernodal else "simplicial", select_interface(cholmod)
        self._symbolic: CholmodInterface | None = analyse(cholmod, self._lower, mode) if n else None

    def factor(self, values: FloatArray) -> Factor:
        if self._symbolic is None:
            return Factor(self.name, np.copy)
        lower = self._lower.copy()
        lower.data = values.copy() if self._source is None else values.ravel()[self._source]
        solve = self._symbolic.factor(lower)
        return Factor(self.name, lambda b: solve(b) if b.size else np.empty(b.shape))


def _expand_blocks(indptr: IntArray, indices: IntArray, block: int) -> tuple[IntArray, IntArray, IntArray]:
    """Expand a pattern of blocks to entries; also return the index of each entry among the block values."""
    number = np.arange(1, block**2 * len(indices) + 1).reshape(-1, block, block)
    upper = sparse.bsr_array((number, indices, indptr), shape=(block * (len(indptr) - 1),) * 2)
    rows = sparse.triu(upper, format="csr")  # the upper triangle in CSR is the lower triangle in CSC
    rows.sort_indices()
    return rows.indptr, rows.indices, rows.data - 1


@cache
def _warn_of_slow_blas() -> None:
    """Warn, once per process, if CHOLMOD uses the slow reference BLAS."""
    blas = find_cholmod_blas()
    if blas is not None and "reference" in blas:
        warnings.warn(
            f"CHOLMOD uses the {blas}, which is three times slower than OpenBLAS on meshes of this size: "
            "install OpenBLAS (Debian: apt install libopenblas0-pthread)",
            FallbackWarning,
            stacklevel=stack_level(),
        )


def find_cholmod_blas() -> str | None:
    """Return the BLAS that CHOLMOD uses, according to the loaded libraries; None if the BLAS is unknown."""
    if not has_cholmod() or not os.path.exists("/proc/self/maps"):
        return None
    from sksparse import cholmod  # noqa: F401, loads the BLAS

    with open("/proc/self/maps", encoding="utf-8") as maps:
        loaded = {line.split()[-1] for line in maps if line.count("/") > 1}
    # the wheels of NumPy and SciPy load their own copy of OpenBLAS, libscipy_openblas, which is ignored
    for path in sorted(loaded):
        name = os.path.basename(path)
        if name.startswith(("libopenblas", "libmkl_rt", "libblis", "libflexiblas", "libblas.so")):
            fast = any(word in path for word in ("openblas", "mkl", "blis", "flexiblas", "atlas"))
            return path if fast else f"reference BLAS ({path})"
    return None
