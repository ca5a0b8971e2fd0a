"""Prescribed angle sums: their rows, their preconditioner, and the convergence of their steps."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import igl
import numpy as np
import pytest
from conftest import bumps
from high_curvature import rings
from reference import angles as reference

from igl_linabf.angles import (
    AngleProblem,
    Constraints,
    HolonomyConstraints,
    State,
    System,
    build_constraints,
    initial_estimate,
    linearise,
    replace_rows_by_identity,
    residual,
    run_active_set,
    take_linear_step,
    take_step_and_chord,
)
from igl_linabf.angles.full_system import take_full_system_step
from igl_linabf.angles.steps.linearisation import solve_for_errors
from igl_linabf.angles.system import factor_laplacians, preconditioner
from igl_linabf.linalg import Solvers
from igl_linabf.surface import Topology, build_manifold_topology

KINDS = ("disk, all", "disk, some", "outer loop", "one hole", "every loop", "part of a hole", "closed")


def build_topology(F: np.ndarray) -> Topology:
    return build_manifold_topology(np.asarray(F, dtype=np.int64), np.arange(F.max() + 1))


def make_prescribed_sums(kind: str) -> tuple[Topology, np.ndarray, np.ndarray]:
    """Return connectivity, angles (3, #F), and sums close to the surface's that obey Gauss-Bonnet."""
    if kind == "closed":  # a sphere with cones at the corners of an inscribed cube
        V, F = igl.upsample(*igl.icosahedron(), 3)
        V = V / np.linalg.norm(V, axis=1)[:, None]
        corners = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) / np.sqrt(3)
        cones = np.linalg.norm(V[:, None] - corners, axis=2).argmin(axis=0)
        sums = np.full(len(V), np.nan)
        sums[cones] = 3 * np.pi / 2
        return build_topology(F), np.ascontiguousarray(igl.internal_angles(V, F).T), sums
    if kind.startswith("disk"):
        V, F = bumps(400)
    else:
        V, F = rings(16, lambda z: 0.3 * z.real**2)
        middle = V[F].mean(axis=1)[:, :2] @ [1, 1j]
        near = np.abs(middle[:, None] - [0.45, -0.4 + 0.3j]).min(axis=1) < 0.22
        V, F, *_ = igl.remove_unreferenced(V, F[~near])
    topology = build_topology(F)
    alpha = np.ascontiguousarray(igl.internal_angles(V, F).T)
    total = topology.sum_at_vertices(alpha)
    sums = np.full(len(V), np.nan)
    chosen = {
        "disk, all": [0],
        "disk, some": [0],
        "outer loop": [0],
        "one hole": [1],
        "every loop": [0, 1, 2],
    }
    for i in chosen.get(kind, [1]):
        loop = topology.loops[i]
        asked = total[loop] + 0.05 * np.cos(7.0 * np.arange(len(loop)))
        asked += (np.pi * len(loop) + (2 * np.pi if i else -2 * np.pi) - asked.sum()) / len(loop)
        if kind in ("disk, some", "part of a hole"):
            asked[::3] = np.nan
        sums[loop] = asked
    return topology, alpha, sums


def make_state(kind: str, solver: str = "auto") -> State:
    topology, alpha, sums = make_prescribed_sums(kind)
    constraints = build_constraints(topology, sums)
    estimate = initial_estimate(topology, alpha, sums=constraints.sums)
    problem = AngleProblem(constraints, estimate, Solvers(solver))
    return State(problem, problem.initial_iterate)


def stack_constraint_rows(constraints: Constraints, system: System) -> np.ndarray:
    """Return the constraint rows, (2 #rows, 3 #F); angle k of face t is column k #F + t."""
    unit = np.eye(system.w.size).reshape(-1, *system.w.shape)
    return np.array([system.compute_constraint_changes(e).ravel() for e in unit]).T


@pytest.mark.parametrize("kind", ["disk, all", "disk, some", "closed"])
def test_the_remaining_rows_are_independent_and_the_omitted_sums_hold(kind: str) -> None:
    state = make_state(kind)
    constraints = state.problem.constraints
    system = System(constraints, state.at.alpha)
    S = system.build_matrix().to_sparse().toarray()
    assert np.linalg.eigvalsh(S).min() > 1e-4
    end = run_active_set(state, 1e-2, 1e-10, 12)
    assert end.at.residual.max_magnitude <= 1e-10
    asked = ~np.isnan(constraints.sums)
    total = constraints.topology.sum_at_vertices(end.at.alpha)
    assert np.abs(total - constraints.sums)[asked].max() < 1e-8  # omitted rows hold as well
    assert np.abs(end.at.residual.log_ratio[constraints.topology.is_interior]).max() < 1e-8


@pytest.mark.parametrize("kind", ["disk, all", "disk, some", "closed"])
def test_in_the_conformal_metric_the_two_kinds_of_rows_are_two_laplacians(kind: str) -> None:
    state = make_state(kind)
    constraints = state.problem.constraints
    system = System(constraints, state.at.alpha)
    M, m = stack_constraint_rows(constraints, system), system.w.shape[1]
    K = np.zeros((3 * m, 3 * m))
    scale = 2 * np.sqrt(system.w.prod(axis=0) / system.d)
    for t, block in enumerate(system.conformal_matrices(np.arange(m)) / scale[:, None, None]):
        K[np.ix_(t + m * np.arange(3), t + m * np.arange(3))] = block
    MKM, n, cot = M @ K @ M.T, constraints.wheels, system.topology.sum_at_edges(system.cot) / 2
    L = constraints.pattern.build_laplacian(cot)
    plus, inner = (
        (part + np.tril(part, -1).T) for part in (L.toarray(), replace_rows_by_identity(L, n).toarray())
    )
    assert np.abs(MKM[0::2, 0::2] - plus).max() < 1e-11
    assert np.abs(MKM[0::2, 1::2]).max() < 1e-11
    assert np.abs((MKM[1::2, 1::2] - inner)[:n, :n]).max() < 1e-11


@pytest.mark.parametrize("kind", ["disk, all", "disk, some"])
def test_the_reduced_step_equals_the_step_of_the_full_system(kind: str) -> None:
    state = make_state(kind, "direct")
    step = take_linear_step(state, 1e-12)
    expected = take_full_system_step(state.problem.constraints, state.at.alpha)
    assert not step.steps[0].limited
    assert np.abs(step.at.alpha - state.at.alpha - expected).max() < 1e-10


@pytest.mark.parametrize("kind", KINDS)
def test_few_steps_reach_sums_wheels_and_closed_loops(kind: str) -> None:
    state = make_state(kind)
    end = run_active_set(state, 1e-2, 1e-10, 12)
    assert end.at.residual.max_magnitude <= 1e-10 and len(end.steps) <= 8
    # few inner steps, because two Laplacians precondition the system
    assert np.mean([step.inner_steps for step in end.steps]) <= 12
    direct = run_active_set(make_state(kind, "direct"), 1e-2, 1e-10, 12)
    # conjugate gradients solve each step only to 1e-2
    assert np.abs(direct.at.alpha - end.at.alpha).max() < 1e-3
    for loop in end.problem.constraints.topology.holes:
        b = end.at.residual
        assert abs(b.turning[loop].sum() + 2 * np.pi) < 1e-8 and abs(b.log_ratio[loop].sum()) < 1e-8
    if kind == "closed":  # the chord step has to approach the sums as well
        chord = take_step_and_chord(state, 0.1, 1e-10).state
        assert [step.kind for step in chord.steps] == ["step", "chord"]
        assert chord.at.residual.max_magnitude < state.at.residual.max_magnitude / 3


@pytest.mark.parametrize("kind", KINDS)
def test_steps_to_prescribed_sums_converge_quadratically(kind: str) -> None:
    """Convergence is quadratic, because the rows are the derivatives of all residuals."""
    left = [step.residual for step in run_active_set(make_state(kind, "direct"), 1e-2, 1e-12, 12).steps]
    last = [(before, after) for before, after in pairwise(left[1:]) if before < 1e-2]
    assert last and all(after < max(30 * before**2, 1e-11) for before, after in last)


@pytest.mark.parametrize("kind", KINDS)
def test_initial_multipliers_change_only_the_number_of_inner_steps(kind: str) -> None:
    state = take_linear_step(make_state(kind), 1e-3)
    lin = linearise(state.problem, state.at, reuse=state.lin)
    plain = solve_for_errors(lin, state.at, 1e-12)
    near = plain.x * (1 + 1e-3 * np.random.default_rng(0).normal(size=len(plain.x)))
    again = solve_for_errors(lin, state.at, 1e-9, None, near)
    assert np.abs(again.e - plain.e).max() < 1e-8 * np.abs(plain.e).max()
    assert again.max_inner_steps < plain.max_inner_steps


@pytest.mark.parametrize("kind", KINDS)
def test_the_preconditioner_is_symmetric_and_positive_with_slivers_and_paths(kind: str, monkeypatch) -> None:
    monkeypatch.setattr(preconditioner, "MIN_SLIVER_RATIO_OF_SMALL_SYSTEM", 1.1)
    state = take_linear_step(make_state(kind), 1e-3, close=False)
    lin = linearise(state.problem, state.at)
    assert lin.slivers.rows is not None and lin.precondition is not None
    n, wheels = state.problem.constraints.n_rows, state.problem.constraints.wheels
    u, v = np.random.default_rng(0).normal(
        size=(2, 2 * n + (0 if lin.holonomy is None else lin.holonomy.rows.n_constraints))
    )
    u[2 * wheels + 1 : 2 * n : 2] = v[2 * wheels + 1 : 2 * n : 2] = 0.0
    Mu, Mv = lin.precondition(u), lin.precondition(v)
    assert abs(u @ Mv - v @ Mu) < 1e-9 * np.sqrt((u @ Mu) * (v @ Mv))


def make_state_with_free_loops(turning: float) -> State:
    """Return a state with free loops and a path around a hole; if `turning` is NaN, it is free, too."""
    topology, alpha, sums = make_prescribed_sums("part of a hole")
    (path,) = build_constraints(topology, sums).paths
    free = replace(topology, n_outer=len(topology.loops))
    constraints = build_constraints(free, None, [replace(path, turning=turning)])
    problem = AngleProblem(constraints, initial_estimate(free, alpha), Solvers())
    return State(problem, problem.initial_iterate)


@pytest.mark.parametrize("kind", ["one hole", "part of a hole", "every loop", -2 * np.pi, -6.0, np.nan])
def test_in_the_conformal_metric_paths_are_closed_exactly(kind: str | float) -> None:
    state = take_linear_step(
        make_state(kind) if isinstance(kind, str) else make_state_with_free_loops(kind), 1e-3, close=False
    )
    constraints = state.problem.constraints
    system = System(constraints, state.at.alpha, scaled=False)
    border = HolonomyConstraints(system, state.at.residual.holonomy, conformal=True)
    lin = linearise(state.problem, state.at, reuse=state.lin)
    z = np.random.default_rng(1).normal(size=2 * constraints.n_rows + border.rows.n_constraints)
    z[2 * constraints.wheels + 1 : 2 * constraints.n_rows : 2] = 0.0
    e = reference.times(
        reference.conformal(system.cot), system.multiply_transposed(lin.multipliers_at_corners(z))
    )
    r = np.concatenate((system.compute_constraint_changes(e).ravel(), border.rows.multiply(e)))
    inverse = factor_laplacians(system, constraints.pattern.get_analysis(Solvers()), system.build_laplacian())
    solved, _ = border.make_preconditioner(system, inverse.solve, None)
    assert np.abs(solved(r) - z).max() <= 1e-7 * np.abs(z).max()


@pytest.mark.parametrize("kind", ["one hole", "part of a hole"])
def test_the_rows_of_a_path_are_the_derivative_of_its_gap(kind: str) -> None:
    state = take_linear_step(make_state(kind), 1e-3, close=False)
    problem, alpha = state.problem, state.at.alpha
    b = state.at.residual
    border = HolonomyConstraints(System(problem.constraints, alpha), b.holonomy.restrict_to_paths(1))
    assert border.rows.n_constraints == (
        1 if kind == "one hole" else 2
    )  # the sums at the vertices determine the turning
    e, h = np.random.default_rng(0).normal(size=alpha.shape), 1e-6
    gap = [residual(problem.constraints, alpha + d * e).holonomy.gap[-1] for d in (h, -h)]
    numeric = (gap[0] - gap[1]) / (2 * h)
    assert (
        np.abs(border.rows.multiply(e) - [numeric.real, numeric.imag][: border.rows.n_constraints]).max()
        < 1e-5
    )


@pytest.mark.parametrize("kind", ["one hole", "part of a hole", "every loop"])
def test_the_bordered_system_agrees_with_its_definition(kind: str) -> None:
    state = take_linear_step(make_state(kind), 1e-3, close=False)
    lin = linearise(state.problem, state.at, reuse=state.lin)
    system, border = lin.system, lin.holonomy
    z = np.random.default_rng(1).normal(size=2 * state.problem.constraints.n_rows + border.rows.n_constraints)
    z[2 * state.problem.constraints.wheels + 1 : 2 * state.problem.constraints.n_rows : 2] = 0.0
    e = system.project(system.multiply_transposed(lin.multipliers_at_corners(z)))
    expected = np.concatenate((system.compute_constraint_changes(e).ravel(), border.rows.multiply(e)))
    assert np.abs(lin.multiply(z) - expected).max() <= 1e-10 * np.abs(expected).max()


def test_the_estimate_is_scaled_to_prescribed_sums_that_differ_much() -> None:
    topology, alpha, sums = make_prescribed_sums("disk, some")
    v = topology.loops[0][1]
    sums[v] = topology.sum_at_vertices(alpha)[v] + 1.2
    bare = initial_estimate(topology, alpha, 1.0, False, sums)
    total = topology.sum_at_vertices(bare)
    assert abs(total[v] - sums[v]) < 1e-12
    others = np.delete(np.arange(topology.n), v)
    assert (total[others] == topology.sum_at_vertices(alpha)[others]).all()
