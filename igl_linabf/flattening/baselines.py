"""Flattening methods with which linear ABF is compared: LSCM, SCP, DNCP and one step of ABF++."""

from collections.abc import Callable
from dataclasses import replace
from time import perf_counter

import igl
import igl.spectra
import numpy as np
from scipy import sparse

from .._types import ComplexArray
from ..angles import (
    Corner,
    Step,
    build_constraints,
    build_fan_rows,
    corner_angles,
    least_norm,
    residual,
    triangle_rows,
    vertex_rows,
)
from ..errors import MeshError, SingularSystemError, first_few
from ..layouts import find_far_points, least_squares
from ..linalg import NotPositiveDefiniteError, SolverName, Solvers
from ..surface import (
    Mesh,
    Pins,
    complex_positions,
    compute_flat_angles,
    find_flipped_faces,
    move_to_pins,
    normalize_placement,
    real_coordinates,
    shape_is_pinned,
    signed_double_areas,
)
from .fallbacks import Problem, StageResult, StageResults, add_layout
from .result import Flattening, FlatteningReport, Hole, Outcome, Residuals

SCP_SIZE = 1 / 32  # square root of the area to which a surface is scaled for the eigensolver of igl


def flatten_by_lscm(mesh: Mesh, pinned: Pins | None) -> Flattening:
    """Run `igl.lscm`, with two distant boundary vertices as the default pins."""
    start = perf_counter()
    b, bc = pinned or find_far_pins(mesh)
    try:
        uv, _ = igl.lscm(mesh.V, mesh.faces, b, bc)
    except RuntimeError:
        raise _make_no_map_error(mesh, "igl.lscm") from None
    return _make_result_of_map("lscm", mesh, complex_positions(uv), "igl.lscm", start, pinned)


def flatten_by_scp(mesh: Mesh, pinned: Pins | None) -> Flattening:
    """Run `igl.spectra.lscm`, the spectral conformal map without pins of Mullen et al. 2008."""
    start = perf_counter()
    if shape_is_pinned(pinned):
        raise MeshError(
            f"scp is only moved to its pins, and there are {len(pinned[0])}: pin two vertices, or use lscm"
        )
    area = mesh.double_area.sum() / 2
    try:  # scale the surface, because the results of the eigensolver depend on the unit of length
        scale = 2.0 ** np.round(np.log2(SCP_SIZE / np.sqrt(area)))
        z = complex_positions(igl.spectra.lscm(scale * mesh.V, mesh.faces))
    except RuntimeError:
        raise _make_no_map_error(mesh, "igl.spectra.lscm") from None
    # the eigenvectors may give a mirrored map
    backwards = len(find_flipped_faces(z, mesh.topology.corner)) > mesh.topology.corner.shape[1] / 2
    z = z.conj() if backwards else z
    covered = signed_double_areas(z, mesh.topology.corner).sum() / 2
    z = z * np.sqrt(area / covered) if covered > 0 else z
    if pinned is not None:
        z = move_to_pins(z, pinned)
    return _make_result_of_map("scp", mesh, z, "igl.spectra.lscm", start, pinned)


def flatten_by_dncp(mesh: Mesh, pinned: Pins | None, solver: SolverName) -> Flattening:
    """Run discrete natural conformal parameterization (Desbrun, Meyer, Alliez 2002) with a free boundary.

    The method minimises the Dirichlet energy, with the cotangents of the surface, minus the area of the map.
    It equals the least-squares layout of the angles of the surface, and has the energy and minimiser of LSCM.
    """
    start = perf_counter()
    b, bc = pinned or find_far_pins(mesh)
    cot = mesh.dot / mesh.double_area
    try:
        z, name = least_squares(mesh.topology, cot, b, complex_positions(bc), Solvers(solver))
    except NotPositiveDefiniteError:
        raise _make_no_map_error(mesh, "DNCP") from None
    return _make_result_of_map("dncp", mesh, z, name, start, pinned)


def take_newton_step(problem: Problem, earlier: StageResults) -> StageResult:
    """Take a single Newton step of ABF++ (Sheffer et al. 2005), the nonlinear problem in angles.

    At zero multipliers, the Hessian is diag(2 / alpha_0^2). Therefore, the step is the least-norm solution of
    the linearised constraints, as in linear ABF, but with the wheel constraint in its product form, prod
    sin(beta) - prod sin(gamma) = 0. The row of this constraint, prod(beta) cot(beta) e_beta - prod(gamma)
    cot(gamma) e_gamma = prod(gamma) - prod(beta), is divided by the geometric mean of the products, which
    does not change the solution.
    """
    state, constraints = problem.initial_state, problem.angles.constraints
    alpha, b = state.at.alpha, state.at.residual
    if constraints.n_rows:
        cot = 1 / np.tan(alpha)
        half = np.exp(-b.wheel / 2)  # sqrt(prod sin(beta) / prod sin(gamma))
        left, right = (build_fan_rows(constraints, cot, which) for which in (Corner.LEFT, Corner.RIGHT))
        wheel = sparse.diags_array(half) @ left - sparse.diags_array(1 / half) @ right
        A = sparse.vstack((vertex_rows(constraints), wheel, triangle_rows(constraints))).tocsr()
        try:
            errors = least_norm(A, alpha, problem.angles.solvers)
        except NotPositiveDefiniteError:
            raise _make_no_map_error(problem.mesh, "the Newton step of ABF++") from None
        e = errors(np.concatenate((b.vertex, 1 / half - half, b.triangle)))
        at = problem.angles.evaluate(alpha + e.reshape(-1, 3).T)
        state = replace(state, at=at, steps=(Step("step", 0, 0, at.residual.max_magnitude),))
    return add_layout(problem, StageResult("linear step", state))


def find_far_pins(mesh: Mesh) -> Pins:
    """Return the default pins: the most distant pair of vertices that halve the length of the outer loop."""
    loop = mesh.topology.loops[0]
    return loop[find_far_points(mesh.V[loop])], np.array([[0.0, 0.0], [1.0, 0.0]])


def make_lscm_call(mesh: Mesh) -> Callable[[], object]:
    """Return a function that calls `igl.lscm` with given pins; other times are relative to its time."""
    faces = mesh.faces
    b, bc = find_far_pins(mesh)
    return lambda: igl.lscm(mesh.V, faces, b, bc)


def _make_result_of_map(
    method: str, mesh: Mesh, z: ComplexArray, solver: str, start: float, pinned: Pins | None
) -> Flattening:
    """Return the result of a method without target angles, with the angles of its map as target angles."""
    topology, constraints = mesh.topology, build_constraints(mesh.topology)
    if not np.isfinite(z).all():
        raise _make_no_map_error(mesh, solver)
    if pinned is None:
        z = normalize_placement(topology, z, mesh.area)
    seconds = {"layout": perf_counter() - start}
    alpha = compute_flat_angles(z, topology.corner)
    flipped = find_flipped_faces(z, topology.corner)
    b = residual(constraints, alpha)
    return Flattening(
        uv=real_coordinates(z),
        F=mesh.faces,
        angles=np.ascontiguousarray(alpha.T),
        method=method,
        outcome=Outcome.FLIPPED if len(flipped) else Outcome.VALID,
        message=f"faces {first_few(flipped)} are flipped: try linear ABF"
        if len(flipped)
        else "no triangle is flipped",
        flipped=flipped,
        before=Residuals.from_residual(residual(constraints, corner_angles(mesh))),
        after=Residuals.from_residual(b),
        holes=Hole.list_all(mesh, b),
        seconds=seconds,
        report=FlatteningReport(layout="least-squares", layout_solver=solver),
    )


def _make_no_map_error(mesh: Mesh, solver: str) -> SingularSystemError:
    """Return the error of a method that found no map, with the thinnest triangles."""
    alpha = corner_angles(mesh)
    thin = np.argsort(alpha.min(axis=0), kind="stable")[:5]
    return SingularSystemError(
        f"{solver} finds no map in double precision; the thinnest triangles are faces {first_few(thin)} "
        f"(smallest angle {alpha[:, thin[0]].min():.1e} rad): collapse them, or use linear ABF"
    )
