"""Both interfaces of scikit-sparse (before and since 0.5) factor the same matrices."""

from __future__ import annotations

import sys
import types
import warnings

import numpy as np
import pytest
from scipy import sparse

from igl_linabf.linalg import NotPositiveDefiniteError, Solvers, cholmod, solvers


class CholmodError(Exception):
    pass


class CholmodNotPositiveDefiniteError(CholmodError):
    pass


class CholmodWarning(Warning):
    pass


class CholeskyFactor:
    """A dense stand-in for the class of scikit-sparse 0.5 with its methods and errors."""

    def __init__(self, A, *, lower: bool = True, order="default", sym_kind=None, supernodal_mode=None):
        assert lower and order == "amd" and supernodal_mode in ("simplicial", "supernodal")
        self.perm = np.arange(A.shape[0])[::-1].astype(np.int32)
        A.data[:] = np.nan  # the real class may reorder the entries of A in place
        self.rcond = -1.0

    def copy(self) -> CholeskyFactor:
        made = CholeskyFactor.__new__(CholeskyFactor)
        made.perm, made.rcond = self.perm, self.rcond
        return made

    def factorize(self, A, ldl=None) -> CholeskyFactor:
        assert isinstance(ldl, bool) and not ldl
        lower = A.toarray()
        A.data[:] = np.nan
        full = (lower + np.tril(lower, -1).T)[np.ix_(self.perm, self.perm)]
        L = np.zeros_like(full)
        for k in range(len(full)):
            pivot = full[k, k] - L[k, :k] @ L[k, :k]
            if pivot <= 0:  # NaN passes this test, as in CHOLMOD
                raise CholmodNotPositiveDefiniteError(f"Not positive definite (code 1) Failed at column {k}.")
            L[k, k] = np.sqrt(pivot)
            L[k + 1 :, k] = (full[k + 1 :, k] - L[k + 1 :, :k] @ L[k, :k]) / L[k, k]
        self.factor = sparse.csc_array(L)
        diagonal = L.diagonal()
        self.rcond = 0.0 if np.isnan(diagonal).any() else float((diagonal.min() / diagonal.max()) ** 2)
        return self

    def solve(self, b, system="A"):
        assert isinstance(b, np.ndarray) and b.ndim in (1, 2)
        if self.rcond < len(self.perm) * np.finfo(float).eps:
            warnings.warn("Matrix is nearly singular.", CholmodWarning, stacklevel=2)
        L, x = self.factor.toarray(), np.empty(b.shape)
        x[self.perm] = np.linalg.solve(L.T, np.linalg.solve(L, b[self.perm]))
        return x


@pytest.fixture
def version_0_5(monkeypatch: pytest.MonkeyPatch) -> None:
    module = types.ModuleType("sksparse.cholmod")
    for kind in (CholeskyFactor, CholmodError, CholmodNotPositiveDefiniteError, CholmodWarning):
        setattr(module, kind.__name__, kind)
    package = types.ModuleType("sksparse")
    package.cholmod = module
    monkeypatch.setitem(sys.modules, "sksparse", package)
    monkeypatch.setitem(sys.modules, "sksparse.cholmod", module)
    monkeypatch.setattr(solvers, "has_cholmod", lambda: True)
    monkeypatch.setattr(cholmod, "find_cholmod_blas", lambda: None)


def lower_of(diagonal: np.ndarray) -> sparse.csc_array:
    n = len(diagonal)
    return sparse.csc_array(sparse.diags_array([np.full(n - 1, -1.0), diagonal], offsets=[-1, 0]))


@pytest.mark.parametrize("threshold", [0, 1000])
def test_systems_are_solved_through_the_interface_of_0_5(
    threshold: int, version_0_5, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(cholmod, "SIMPLICIAL_ROWS", threshold)
    lower = lower_of(np.full(20, 2.5))
    full, values = lower + sparse.tril(lower, -1).T, lower.data.copy()
    analysis = Solvers("cholmod").analyse(lower.indptr, lower.indices)
    first, second = analysis.factor(values), analysis.factor(2 * values)
    for sides in ((), (0,), (3,)):
        b = np.random.default_rng(0).normal(size=(20, *sides))
        assert np.allclose(full @ first.solve(b), b)
        assert np.allclose(2 * full @ second.solve(b), b)
    assert (values == lower.data).all()  # factorization does not change the values of the caller


@pytest.mark.parametrize("bad", [-3.0, 0.0, np.nan])
def test_a_bad_pivot_is_named_by_its_row_through_the_interface_of_0_5(bad: float, version_0_5) -> None:
    lower = lower_of(np.full(20, 2.5))
    row, column = lower.indices, np.repeat(np.arange(20), np.diff(lower.indptr))
    values = np.where((row == 7) | (column == 7), 0.0, lower.data)
    values[(row == 7) & (column == 7)] = bad
    with pytest.raises(NotPositiveDefiniteError) as caught:
        Solvers("cholmod").analyse(lower.indptr, lower.indices).factor(values)
    assert caught.value.row == 7


def test_a_nearly_singular_system_is_solved_without_a_warning_of_0_5(version_0_5) -> None:
    lower = lower_of(np.full(20, 2.5))
    scale = 10.0 ** -np.arange(20)
    lower.data *= scale[lower.indices] * scale[np.repeat(np.arange(20), np.diff(lower.indptr))]
    factor = Solvers("cholmod").analyse(lower.indptr, lower.indices).factor(lower.data)
    assert np.isfinite(factor.solve(np.ones(20))).all()
