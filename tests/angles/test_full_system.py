"""A second implementation of the whole method, written from the paper without code of the package."""

from __future__ import annotations

import igl
import numpy as np
import pytest
from conftest import best_fit_distance, bumps, load, tree_cut
from scipy import sparse
from scipy.sparse.linalg import splu, spsolve

from igl_linabf import linabf

CUTS = {"pial, 5 leaves": 5, "pial, 8 leaves": 8, "pial, 12 leaves": 12}
PLATES = {"wavy": (400, 3, 0.6), "hills": (2000, 5, 0.5), "swell": (1200, 7, 0.8)}
EVERYWHERE = ("bumps", *CUTS, *PLATES)
LARGE = ("cortex", "cortex_right")
SHARED = (
    "disk__bff_hemisphere.obj",
    "disk__igl_camel_b.obj",
    "disk__igl_lilium.obj",
    "disk__igl_lion.off",
    "disk__igl_snail.obj",
    "disk__optcuts_foot_i_f10000.obj",
    "stress__optcuts_duck1.obj",
)


def solve_paper_angles(V: np.ndarray, F: np.ndarray) -> np.ndarray:
    """Solve eq. 5, 6 and 10 with the least relative change (eq. 11-16), from the estimate of section 4.2."""
    a, n, m = igl.internal_angles(V, F), len(V), len(F)
    rim = np.unique(igl.boundary_facets(F)[0])
    total = np.bincount(F.ravel(), a.ravel(), n)
    total[rim] = 2 * np.pi
    a = a * np.where(np.abs(total - 2 * np.pi) > 1, 2 * np.pi / total, 1)[F]
    inside = np.delete(np.arange(n), rim)
    row = np.full(n, -1)
    row[inside] = np.arange(len(inside))
    corner = np.arange(3 * m).reshape(m, 3)
    at = row[F] >= 0
    i, here = row[F][at], corner[at]
    beta, gamma = np.roll(corner, -1, axis=1)[at], np.roll(corner, -2, axis=1)[at]
    a = a.ravel()
    cot, log = 1 / np.tan(a), np.log(np.sin(a))
    shape = len(inside), 3 * m
    vertex = sparse.csr_array((np.ones(len(i)), (i, here)), shape=shape)
    both = np.append(i, i), np.append(beta, gamma)
    wheel = sparse.csr_array((np.append(cot[beta], -cot[gamma]), both), shape=shape)
    triangle = sparse.kron(sparse.eye_array(m), np.ones((1, 3)))
    missing = np.bincount(i, log[gamma] - log[beta], len(inside))
    right = np.concatenate((2 * np.pi - vertex @ a, missing, np.pi - triangle @ a))
    C = sparse.vstack((vertex, wheel, triangle)) @ sparse.diags_array(a)
    return (a + a * (C.T @ spsolve((C @ C.T).tocsc(), right))).reshape(m, 3)


def build_paper_energy(F: np.ndarray, a: np.ndarray) -> sparse.csc_array:
    """Return the matrix of section 5's conformal energy: rows z2 - z0 - c (z1 - z0), for angles `a`."""
    c = np.sin(a[:, 1]) / np.sin(a[:, 2]) * np.exp(1j * a[:, 0])
    values = np.column_stack((c - 1, -c, np.ones(len(F)))) / np.sqrt(c.imag)[:, None]
    t = np.repeat(np.arange(len(F)), 3)
    rows = sparse.csc_array((values.ravel(), (t, F.ravel())), shape=(len(F), F.max() + 1))
    return (rows.conj().T @ rows).tocsc()


def mesh(name: str) -> tuple[np.ndarray, np.ndarray]:
    if name in CUTS:
        return tree_cut(*load("pial"), CUTS[name])
    return bumps(*PLATES[name]) if name in PLATES else load(name)


@pytest.mark.filterwarnings("ignore:.*overlaps itself:igl_linabf.OutcomeWarning")
@pytest.mark.parametrize(
    "name", [*EVERYWHERE, *SHARED, *(pytest.param(name, marks=pytest.mark.slow) for name in LARGE)]
)
def test_the_full_system_of_the_paper_gives_the_same_map(name: str) -> None:
    V, F = mesh(name)
    options = {"iterations": 1, "safeguard": False, "layout": "least-squares"}
    exact, default = linabf(V, F, **options, rtol=1e-12), linabf(V, F, **options)
    E = build_paper_energy(F, solve_paper_angles(V, F))
    # find the two pins: the gradient of the energy vanishes at all other vertices
    pins = np.argsort(np.abs(E @ (exact @ [1, 1j])))[-2:]
    free = np.delete(np.arange(len(V)), pins)
    z = (exact @ [1, 1j]).astype(complex)
    z[free] = splu(E[free][:, free]).solve(-(E[free][:, pins] @ z[pins]))
    uv = np.column_stack((z.real, z.imag))
    assert best_fit_distance(exact, uv) <= 1e-7
    assert best_fit_distance(default, uv) <= 1.5e-2  # the default tolerance of the inner solver is coarse
