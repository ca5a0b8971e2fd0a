"""The linear system is equivalent to the paper's, and its angles belong to a flat mesh."""

from __future__ import annotations

import igl
import numpy as np
import pytest
from conftest import CARRIED_HOLES, DISKS, HOLES, load
from scipy import sparse

from igl_linabf import LinABF, flatten
from igl_linabf.angles import (
    CAP_ANGLE,
    AngleProblem,
    State,
    System,
    build_constraints,
    corner_angles,
    initial_estimate,
    limit_obtuse_angles,
    residual,
    take_linear_step,
)
from igl_linabf.angles.full_system import (
    build_interior_rows,
    compute_right_hand_sides,
    take_full_system_step,
    triangle_rows,
)
from igl_linabf.flattening import linabf_angles
from igl_linabf.linalg import Solvers, has_cholmod
from igl_linabf.surface import Mesh, build_topology, measure_faces, planar_mesh

SURFACES = ("bumps", "cortex", *DISKS)


def compute_step(mesh: Mesh, alpha: np.ndarray, solver: str) -> np.ndarray:
    """Return the changes of the angles in one step of the reduced system without safeguard."""
    problem = AngleProblem(build_constraints(mesh.topology), alpha, Solvers(solver), safeguard=False)
    return take_linear_step(State(problem, problem.initial_iterate), 1e-12, close=False).at.alpha - alpha


@pytest.mark.parametrize("name", SURFACES)
def test_reduced_step_equals_the_papers_full_system(name: str) -> None:
    if name.endswith("face.obj") and not has_cholmod():
        pytest.skip("SuperLU takes minutes for the full system of face")
    mesh = planar_mesh(*load(name))
    alpha = initial_estimate(mesh.topology, corner_angles(mesh))
    expected = take_full_system_step(build_constraints(mesh.topology), alpha)
    for solver in ("direct", "auto"):
        assert np.abs(compute_step(mesh, alpha, solver) - expected).max() <= 1e-9


def test_reduced_step_equals_the_full_system_where_triangles_do_not_sum_to_pi() -> None:
    mesh = planar_mesh(*load("bumps"))
    rng = np.random.default_rng(1)
    alpha = corner_angles(mesh)
    alpha *= rng.uniform(0.9, 1.1, alpha.shape)
    expected = take_full_system_step(build_constraints(mesh.topology), alpha)
    assert np.abs(compute_step(mesh, alpha, "direct") - expected).max() <= 1e-9


@pytest.mark.parametrize("name", [*CARRIED_HOLES, *HOLES])
def test_a_hole_adds_one_row_to_the_system(name: str) -> None:
    V, F = load(name)
    vertices = np.arange(len(V))
    topology = build_topology(F, vertices)
    assert len(topology.loops) > 1
    constraints = build_constraints(topology)
    double_area, dot = measure_faces(V, topology.corner, vertices)
    alpha = np.arctan2(double_area, dot)
    system = System(constraints, alpha)
    M = build_interior_rows(constraints, alpha)
    w = (alpha**2).T.ravel()
    triangles = triangle_rows(constraints)
    W = sparse.diags_array(w)
    MWT = M @ W @ triangles.T
    S = M @ W @ M.T - MWT @ sparse.diags_array(1 / (triangles @ w)) @ MWT.T
    assert abs(system.build_matrix().to_sparse() - S).max() <= 1e-12 * abs(S).max()
    wanted, _ = compute_right_hand_sides(constraints, alpha)
    missing = residual(constraints, alpha)
    assert np.allclose(np.column_stack((missing.vertex, missing.wheel)).ravel(), wanted, atol=1e-10)


@pytest.mark.parametrize("name", SURFACES)
def test_in_the_conformal_metric_the_system_is_two_laplacians(name: str) -> None:
    V, F = load(name)
    mesh = planar_mesh(V, F)
    alpha = corner_angles(mesh)
    c = 1 / np.tan(alpha)
    element = np.zeros((alpha.shape[1], 3, 3))
    for k in range(3):
        i, j = (k + 1) % 3, (k + 2) % 3
        element[:, i, j] = element[:, j, i] = -c[k] / 2
        element[:, k, k] = (c[i] + c[j]) / 2
    m = len(element)
    K = sparse.bsr_array((element, np.arange(m), np.arange(m + 1)), shape=(3 * m, 3 * m))
    M = build_interior_rows(build_constraints(mesh.topology), alpha)
    S = (M @ K @ M.T).tocsr()
    inside = mesh.topology.is_interior
    L = -igl.cotmatrix(V, F)[inside][:, inside]
    scale = abs(L).max()
    assert abs(S[0::2][:, 0::2] - L).max() <= 1e-9 * scale
    assert abs(S[1::2][:, 1::2] - L).max() <= 1e-9 * scale
    assert abs(S[0::2][:, 1::2]).max() <= 1e-9 * scale
    weight = mesh.topology.sum_at_edges(c) / 2
    lower = build_constraints(mesh.topology).pattern.build_laplacian(weight)
    assert abs(lower - sparse.tril(L)).max() <= 1e-9 * scale


@pytest.mark.parametrize("name", SURFACES)
def test_converged_angles_are_those_of_a_flat_mesh(name: str) -> None:
    V, F = load(name)
    result = flatten(V, F, method=LinABF(iterations=12))
    angles = result.angles
    sums = np.zeros(len(V))
    np.add.at(sums, F, angles)
    interior = np.ones(len(V), dtype=bool)
    interior[igl.boundary_loop(F)] = False
    assert np.abs(angles.sum(axis=1) - np.pi).max() <= 1e-12
    assert np.abs(sums[interior] - 2 * np.pi).max() <= 1e-8
    boundary = ~interior
    assert abs((np.pi - sums[boundary]).sum() - 2 * np.pi) <= 1e-8 * len(V)
    # exclude triangles below a millionth of the map, whose angles are not determined in double precision
    wide = np.ptp(result.uv[F], axis=1).max(axis=1) > 1e-6 * np.ptp(result.uv)
    assert np.abs(igl.internal_angles(result.uv, F) - angles)[wide].max() <= 1e-4
    assert (linabf_angles(V, F, iterations=12) == angles).all()


def test_the_exponential_map_switch_scales_only_spikes() -> None:
    V, F = load("bumps")
    mesh = planar_mesh(V, F)
    flat = np.array(V)
    flat[:, 2] = 0
    spike = int(np.flatnonzero(mesh.topology.is_interior)[0])
    flat[spike, 2] = 0.06
    mesh = planar_mesh(flat, F)
    alpha = corner_angles(mesh)
    total = mesh.topology.sum_at_vertices(alpha)
    far = (mesh.topology.is_interior) & (np.abs(total - 2 * np.pi) > 1.0)
    assert far[spike]
    assert far.sum() < 5
    bare = initial_estimate(mesh.topology, alpha, threshold=1.0, to_triangles=False)
    scaled = mesh.topology.sum_at_vertices(bare)
    assert np.allclose(scaled[far], 2 * np.pi)
    assert (scaled[~far] == total[~far]).all()
    assert np.allclose(initial_estimate(mesh.topology, alpha, threshold=1.0).sum(axis=0), np.pi)
    assert (initial_estimate(mesh.topology, alpha, threshold=7.0) == alpha).all()


def test_caps_are_opened_to_the_least_angle_and_triangles_stay_triangles() -> None:
    small = np.array([[1e-9, 3e-9], [4e-8, 5e-8], [6e-8, 5e-8], [0.2, 1e-12]])
    alpha = np.insert(small, 1, np.pi - small.sum(axis=1), axis=1).T
    opened, caps = limit_obtuse_angles(alpha)
    assert caps.tolist() == [0, 1]
    assert np.abs(opened.sum(axis=0) - np.pi).max() < 1e-14
    np.testing.assert_allclose(np.pi - opened.max(axis=0)[caps], CAP_ANGLE, rtol=1e-7)
    np.testing.assert_allclose(opened[0, caps] / opened[2, caps], small[caps, 0] / small[caps, 1])
    assert (opened[:, 2:] == alpha[:, 2:]).all()
