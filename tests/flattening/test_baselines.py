"""The baseline methods do what their names say."""

from __future__ import annotations

import igl
import igl.spectra
import numpy as np
import pytest
from conftest import best_fit_distance, load

from igl_linabf import MeshError, OutcomeWarning, flatten, lscm
from igl_linabf.angles import corner_angles, initial_estimate
from igl_linabf.flattening import METHODS, Outcome, find_far_pins
from igl_linabf.surface import planar_mesh

NAMES = ("bumps", "cortex", "disk__igl_camelhead.off", "disk__igl_lion.off", "disk__igl_camel_b.obj")


def conformal_energy(V: np.ndarray, F: np.ndarray, uv: np.ndarray) -> float:
    """Return the conformal energy of a map: the Dirichlet energy minus the signed area."""
    return float(-(uv * (igl.cotmatrix(V, F) @ uv)).sum() / 2 - igl.doublearea(uv, F).sum() / 2)


@pytest.mark.parametrize("method", METHODS)
def test_every_method_reproduces_a_flat_mesh(method: str) -> None:
    V, F = load("bumps")
    V = V * [1, 1, 0]
    assert best_fit_distance(flatten(V, F, method=method).uv, V[:, :2]) < 1e-7


@pytest.mark.parametrize("method", METHODS)
def test_every_method_meets_two_pins(method: str) -> None:
    V, F = load("bumps")
    b, bc = np.array([5, 40]), np.array([[1.0, 2.0], [-3.0, 0.5]])
    assert np.abs(flatten(V, F, b, bc, method=method).uv[b] - bc).max() < 1e-10


@pytest.mark.parametrize("name", NAMES)
def test_dncp_equals_lscm_with_the_same_pins(name: str) -> None:
    V, F = load(name)
    loop = igl.boundary_loop(F)
    b, bc = loop[[0, len(loop) // 3]], [[0, 0], [1, 0]]
    dncp, by_igl = flatten(V, F, b, bc, method="dncp").uv, flatten(V, F, b, bc, method="lscm").uv
    assert np.abs(dncp - by_igl).max() <= 1e-6 * np.ptp(by_igl, axis=0).max()
    assert (by_igl == igl.lscm(V, F, b, np.array(bc, dtype=float))[0]).all()


@pytest.mark.parametrize("name", NAMES)
def test_default_pins_of_lscm_are_two_far_boundary_vertices(name: str) -> None:
    V, F = load(name)
    (i, j), bc = find_far_pins(planar_mesh(V, F))
    loop = igl.boundary_loop(F).tolist()
    assert abs(abs(loop.index(i) - loop.index(j)) / len(loop) - 0.5) < 0.25
    assert np.linalg.norm(V[i] - V[j]) > 0.5 * np.linalg.norm(np.ptp(V[loop], axis=0))
    uv = flatten(V, F, method="lscm").uv
    assert best_fit_distance(uv, igl.lscm(V, F, np.array([i, j]), bc)[0]) < 1e-9
    assert np.isclose(np.abs(igl.doublearea(uv, F)).sum(), igl.doublearea(V, F).sum())


@pytest.mark.parametrize("name", NAMES)
def test_the_spectral_map_has_no_pins_and_less_energy_than_lscm(name: str) -> None:
    V, F = load(name)
    scp = flatten(V, F, method="scp").uv
    scale = 2 ** np.round(-np.log2(np.sqrt(igl.doublearea(V, F).sum() / 2) * 32))
    by_igl = igl.spectra.lscm(scale * V, F)  # igl returns other eigenvectors at other sizes
    assert min(best_fit_distance(scp, by_igl), best_fit_distance(scp, by_igl * [1, -1])) < 1e-9
    rim = np.array(igl.boundary_loop(F))

    def by_rim(uv: np.ndarray) -> float:
        """Return the objective of the spectral map: conformal energy over the variance of the boundary."""
        variance = ((uv[rim] - uv[rim].mean(axis=0)) ** 2).sum()
        return conformal_energy(V, F, uv) / variance

    assert by_rim(scp) <= by_rim(flatten(V, F, method="lscm").uv) * (1 + 1e-6)


def constraints(F: np.ndarray, alpha: np.ndarray, interior: np.ndarray) -> np.ndarray:
    """Return the residuals of the vertex, wheel (product form of ABF) and triangle constraints."""
    values = []
    for v in interior:
        t, k = np.nonzero(v == F)
        values.append(alpha[t, k].sum() - 2 * np.pi)
        values.append(np.sin(alpha[t, (k + 1) % 3]).prod() - np.sin(alpha[t, (k + 2) % 3]).prod())
    return np.concatenate((values, alpha.sum(axis=1) - np.pi))


def test_one_step_of_abfpp_is_newtons_step_of_the_problem_in_products() -> None:
    V, F = igl.icosahedron()
    V, F = igl.upsample(V * [1, 1.5, 0.7], F[2:], 1)
    mesh = planar_mesh(V, F)
    interior = np.flatnonzero(mesh.topology.is_interior)
    start = initial_estimate(mesh.topology, corner_angles(mesh), to_triangles=False).T
    h = 1e-6
    jacobian = np.stack(
        [
            (constraints(F, start + d, interior) - constraints(F, start - d, interior)) / (2 * h)
            for d in h * np.eye(start.size).reshape(-1, *start.shape)
        ],
        axis=1,
    )
    # Lagrangian sum ((a - a0) / a0)^2 + x . c(a) at x = 0, a = a0
    hessian = np.diag(2 / start.ravel() ** 2)
    n = len(jacobian)
    system = np.block([[hessian, jacobian.T], [jacobian, np.zeros((n, n))]])
    right = np.concatenate((np.zeros(start.size), -constraints(F, start, interior)))
    step = np.linalg.lstsq(system, right, rcond=None)[0][: start.size].reshape(start.shape)
    result = flatten(V, F, method="one-step-abf++")
    assert np.abs(result.angles - start - step).max() < 1e-7
    assert result.report.iterations == 1


@pytest.mark.parametrize("name", ["ball", "disk__igl_camel_b.obj"])
def test_lscm_warns_of_flips_and_checks_its_input(name: str) -> None:
    V, F = load(name)
    with pytest.warns(OutcomeWarning, match="flipped"):
        uv = lscm(V, F)
    result = flatten(V, F, method="lscm")
    assert result.outcome is Outcome.FLIPPED
    assert (uv == result.uv).all()
    with pytest.raises(MeshError, match="pin two or more"):
        lscm(V, F, [0], [[0, 0]])
    with pytest.raises(MeshError, match="closed"):
        lscm(*igl.icosahedron())


@pytest.mark.parametrize("method", ["lscm", "scp"])
def test_a_method_refuses_options_that_it_does_not_have(method: str) -> None:
    with pytest.raises(ValueError, match="tol"):
        METHODS[method](tol=1e-3)
