"""Holes without cuts: loops turn once, keep their scale, and close."""

from __future__ import annotations

from functools import cache

import igl
import numpy as np
import pytest
from conftest import HOLES, best_fit_distance
from holed_surfaces import surface

from igl_linabf import ABF, LinABF, MeshError, abf, flatten, linabf, quality
from igl_linabf.angles import (
    AngleProblem,
    HolonomyConstraints,
    Linearisation,
    State,
    System,
    build_constraints,
    compute_holonomy_residual,
    corner_angles,
    initial_estimate,
    linearise,
    residual,
    take_linear_step,
)
from igl_linabf.flattening import Flattening, Outcome
from igl_linabf.layouts import layout
from igl_linabf.linalg import Solvers, has_cholmod
from igl_linabf.surface import planar_mesh

CURVED = ("wavy plate", "hemisphere", "crown", "pial_with_holes", *HOLES)


@cache
def flatten_converged(name: str) -> Flattening:
    """Return the map after at most twelve iterations, cached for several tests."""
    return flatten(*surface(name), method=LinABF(iterations=12))


@pytest.mark.parametrize("name", ["annulus", "plate", "comb", "slot"])
@pytest.mark.parametrize("method", ["linabf", "abf", "isometric", "lscm", "dncp", "one-step-abf++"])
def test_a_flat_plate_with_holes_is_reproduced(name: str, method: str) -> None:
    V, F = surface(name)
    result = flatten(V, F, method=method)
    assert len(result.holes) == (30 if name == "plate" else 1)
    assert best_fit_distance(result.uv, V[:, :2]) < 1e-6


@pytest.mark.parametrize("name", CURVED)
def test_every_closure_residual_vanishes_within_twelve_iterations(name: str) -> None:
    V, F = surface(name)
    result = flatten_converged(name)
    assert result.outcome is Outcome.CONVERGED
    assert result.report.iterations <= 12
    assert result.holes
    for hole in result.holes:
        assert max(hole.rotation, hole.scale, hole.translation) < 1e-8
    assert quality(V, F, result.uv).flips == 0


@pytest.mark.parametrize("name", CURVED)
def test_converged_angles_make_a_single_valued_map_around_every_hole(name: str) -> None:
    V, F = surface(name)
    for angles in (flatten_converged(name).angles, flatten(V, F, method=ABF(tol=1e-9)).angles):
        least, greedy, drawn = (layout(F, angles, method=m) for m in ("least-squares", "greedy", "auto"))
        assert max(best_fit_distance(uv, least) for uv in (greedy, drawn)) < 1e-5
        assert np.abs(igl.internal_angles(least, F) - angles).max() < 1e-5


@pytest.mark.parametrize("name", CURVED)
def test_no_flips_and_less_distortion_than_igl_lscm(name: str) -> None:
    V, F = surface(name)
    theirs = quality(V, F, flatten(V, F, method="lscm").uv)
    one, default, converged = (
        quality(V, F, uv) for uv in (linabf(V, F, iterations=1), linabf(V, F), abf(V, F))
    )
    assert one.flips == default.flips == converged.flips == 0
    assert max(one.angle_distortion, default.angle_distortion) < theirs.angle_distortion
    assert converged.angle_distortion < 1.001 * min(one.angle_distortion, default.angle_distortion)
    if name == "holes__igl_halftunnel.off":
        assert theirs.flips > 0
        assert default.angle_distortion < 2 / 3 * theirs.angle_distortion


def test_the_rows_of_the_border_are_the_derivative_of_the_gap() -> None:
    mesh = planar_mesh(*surface("wavy plate"))
    topology = mesh.topology
    constraints = build_constraints(topology)
    alpha = initial_estimate(topology, corner_angles(mesh))
    system = System(constraints, alpha)
    holonomy = residual(constraints, alpha).holonomy
    border = HolonomyConstraints(system, holonomy)
    e = np.random.default_rng(0).normal(size=alpha.shape)
    h = 1e-6
    gaps = [residual(constraints, alpha + d * e).holonomy.gap for d in (h, -h)]
    numeric = (gaps[0] - gaps[1]) / (2 * h)
    exact = border.rows.multiply(e).reshape(-1, 2) @ [1, 1j]
    # the rows neglect that the gap of an open loop depends on its length and on its starting vertex
    slack = 3 * np.abs(holonomy.gap) * np.abs(e).max() * max(map(len, topology.loops[1:]))
    assert (np.abs(numeric - exact) <= 1e-6 + slack).all()
    assert (slack < 0.3 * np.abs(exact)).any()


def test_developed_loops_do_not_depend_on_their_starting_vertex() -> None:
    mesh = planar_mesh(*surface("wavy plate"))
    missing = residual(build_constraints(mesh.topology), corner_angles(mesh))
    turned = planar_mesh(mesh.V, mesh.faces)
    loops = (turned.topology.loops[0], *(np.roll(loop, 3) for loop in turned.topology.loops[1:]))
    object.__setattr__(turned.topology, "loops", loops)
    again = compute_holonomy_residual(turned.topology, missing.turning, missing.log_ratio)
    assert np.allclose(np.abs(again.gap), np.abs(missing.holonomy.gap), atol=1e-12)


def build_bordered_system() -> Linearisation:
    """Return the linear system of a plate with holes after the first step, with the rows of the loops."""
    mesh = planar_mesh(*surface("wavy plate"))
    estimate = initial_estimate(mesh.topology, corner_angles(mesh))
    problem = AngleProblem(build_constraints(mesh.topology), estimate, Solvers("auto"))
    state = take_linear_step(State(problem, problem.initial_iterate), 1e-3, close=False)
    return linearise(problem, state.at, reuse=state.lin)


def test_the_bordered_system_agrees_with_its_definition() -> None:
    lin = build_bordered_system()
    system, border = lin.system, lin.holonomy
    z = np.random.default_rng(1).normal(size=2 * lin.problem.constraints.n_rows + border.rows.n_constraints)
    e = system.project(system.multiply_transposed(lin.multipliers_at_corners(z)))
    expected = np.concatenate((system.compute_constraint_changes(e).ravel(), border.rows.multiply(e)))
    assert np.abs(lin.multiply(z) - expected).max() <= 1e-10 * np.abs(expected).max()


def test_in_the_conformal_metric_the_bordered_system_is_solved_exactly() -> None:
    lin = build_bordered_system()
    constraints, alpha = lin.problem.constraints, np.sqrt(lin.system.w)
    system = System(constraints, alpha, scaled=False)
    border = HolonomyConstraints(system, residual(constraints, alpha).holonomy, conformal=True)
    z = np.random.default_rng(1).normal(size=2 * lin.problem.constraints.n_rows + border.rows.n_constraints)
    y = system.multiply_transposed(lin.multipliers_at_corners(z))
    e = np.einsum("tij,jt->it", system.conformal_matrices(np.arange(y.shape[1])), y)
    r = np.concatenate((system.compute_constraint_changes(e).ravel(), border.rows.multiply(e)))
    L = Solvers().factor(system.build_laplacian())
    solve, _ = border.make_preconditioner(system, L.solve, None)
    assert np.abs(solve(r) - z).max() <= 1e-7 * np.abs(z).max()


@pytest.mark.parametrize("solver", ["direct", *["cholmod"] * has_cholmod()])
def test_every_solver_ends_at_the_same_map(solver: str) -> None:
    V, F = surface("holes__igl_halftunnel.off")
    options = {"iterations": 12, "rtol": 1e-9}
    assert best_fit_distance(linabf(V, F, solver=solver, **options), linabf(V, F, **options)) < 1e-6


def test_maps_do_not_depend_on_rigid_motion_scale_or_numbering() -> None:
    V, F = surface("wavy plate")
    rng = np.random.default_rng(0)
    new = rng.permutation(len(V))
    moved = np.empty_like(V)
    moved[new] = 1e4 * (V[:, [2, 0, 1]] + 3)
    for make in (lambda V, F: linabf(V, F, iterations=2, rtol=1e-10), lambda V, F: abf(V, F, tol=1e-9)):
        uv = make(V, F)
        again = make(moved, new[F][rng.permutation(len(F))])[new]
        assert best_fit_distance(again, uv) < 1e-6


def test_the_outer_loop_is_the_longest_or_the_requested_one() -> None:
    V, F = surface("crown")
    found = igl.boundary_loop_all(F)
    length = [np.linalg.norm(V[loop] - V[np.roll(loop, 1)], axis=1).sum() for loop in found]
    loops = [found[i] for i in np.argsort(length)]
    default = flatten_converged("crown")
    assert {hole.vertex in loops[-1] for hole in default.holes} == {False}
    small = int(loops[0][1])
    other = flatten(V, F, method=LinABF(iterations=12), outer=small)
    assert sum(hole.vertex in loops[-1] for hole in other.holes) == 1
    assert not any(hole.vertex in loops[0] for hole in other.holes)
    assert max(hole.largest for hole in other.holes) < 1e-8
    assert len(other.flipped) == 0
    with pytest.raises(MeshError, match="on no boundary loop: give a vertex of one of the 8 loops"):
        flatten(V, F, outer=int(np.setdiff1d(np.arange(len(V)), np.concatenate(loops))[0]))
    with pytest.raises(MeshError, match="outer is 'rim'"):
        flatten(V, F, outer="rim")


def test_a_boundary_layout_is_refused_with_a_remedy() -> None:
    with pytest.raises(
        MeshError, match=r"^the mesh has 8 boundary loops, and layout='boundary' draws one: use"
    ):
        linabf(*surface("crown"), layout="boundary")
