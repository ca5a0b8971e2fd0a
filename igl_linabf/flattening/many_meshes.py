"""Flatten many meshes: small disks share a linear system, all other meshes are flattened one by one."""

from __future__ import annotations

import warnings
from collections.abc import Iterator, Sequence
from functools import partial
from time import perf_counter
from typing import Literal, cast, overload

import numpy as np
from numpy.typing import ArrayLike

from .._core import side_products
from .._runtime import Progress, advance, map_in_threads, progress_part, show_progress, stopwatch
from .._types import FloatArray, IntArray
from ..angles import Step
from ..errors import MeshError, OutcomeWarning, SingularSystemError, first_few, stack_level
from ..linalg import NotPositiveDefiniteError
from ..measures import find_crossed_loops, find_overlapping_pairs
from ..surface import (
    Ragged,
    complex_positions,
    concatenate_sound_disks,
    face_array,
    signed_double_areas,
    vertex_array,
)
from .batches import LinearBatch, flatten_linear_batch, iterate_isometric_maps
from .boundary_shapes import BoundaryName
from .constants import MOST_STRETCH
from .functions import compute_least_stretch, flatten
from .methods import STAGES, Isometric, LinABF, Method, resolve_method
from .result import (
    NO_INDICES,
    Attempt,
    Findings,
    Flattening,
    FlatteningReport,
    Residuals,
    Status,
    determine_outcome,
    report_overlaps,
)

MAX_SHARED_FACES = 10_000  # maximum number of triangles of a mesh in a shared linear system
FACES_PER_SYSTEM = 4 * MAX_SHARED_FACES  # a shared linear system is full from this number of triangles

Arrays = tuple[FloatArray, IntArray]


@overload
def flatten_many(
    meshes: Sequence[tuple[ArrayLike, ArrayLike]],
    *,
    method: str | Method = "linabf",
    boundary: BoundaryName = "free",
    errors: Literal["raise"] = "raise",
    progress: Progress = None,
) -> list[Flattening]: ...


@overload
def flatten_many(
    meshes: Sequence[tuple[ArrayLike, ArrayLike]],
    *,
    method: str | Method = "linabf",
    boundary: BoundaryName = "free",
    errors: Literal["return"],
    progress: Progress = None,
) -> list[Flattening | MeshError]: ...


def flatten_many(
    meshes: Sequence[tuple[ArrayLike, ArrayLike]],
    *,
    method: str | Method = "linabf",
    boundary: BoundaryName = "free",
    errors: Literal["raise", "return"] = "raise",
    progress: Progress = None,
) -> list[Flattening] | list[Flattening | MeshError]:
    """Flatten many meshes: the same results as `flatten` in a loop, in less time.

    Small disks share linear systems, because disks do not interact. A system is assembled, analysed and
    factored once, while each disk has its own steps, residuals and outcome. Several threads process different
    systems: one thread per core, or the number of threads in OMP_NUM_THREADS. Isometric maps start from the
    maps of linear ABF.

    Only linear ABF and isometric maps share systems. A mesh is flattened alone if it is large, if it has
    holes, if the shape of its boundary is prescribed, if it needs more than the two solves of linear ABF, or
    if its isometric map starts far from an isometry.

    Parameters
    ----------
    meshes : sequence of (V, F)
        As in `flatten`: vertex positions (#V, 3) float and triangles (#F, 3) int of each mesh.
    method : str or method object
        As in `flatten`.
    boundary : {"free", "circle", "circles", "rectangle"}
        As in `flatten`, for all meshes; the corners of rectangles are detected.
    errors : {"raise", "return"}
        If `flatten` raises a `MeshError` for a mesh, "raise" raises it with the index of the mesh, and
        "return" puts it into the list in place of the result.
    progress : callable or False, optional
        As in `flatten`.

    Returns
    -------
    list of Flattening, or of Flattening and MeshError
        Results in the order of `meshes`. Maps and angles agree with `flatten` to 1e-10, and outcomes and
        attempts are the same. The `seconds` of meshes that were solved together are divided in proportion to
        their triangles.

    Raises
    ------
    MeshError
        With errors="raise": as in `flatten`, for the first bad mesh.
    ValueError
        The name of the method or the value of `errors` is unknown.

    Warns
    -----
    OutcomeWarning
        As in `flatten`. For meshes that were solved together, there is one warning with their indices.

    Examples
    --------
    >>> import igl
    >>> V, F = igl.icosahedron()
    >>> disk, closed = flatten_many([(V, F[1:]), (V, F)], errors="return")
    >>> disk.outcome.value, str(closed)[:18]
    ('valid', 'the mesh is closed')
    """
    chosen, given = resolve_method(method), list(meshes)
    if errors not in ("raise", "return"):
        raise ValueError(f"errors is {errors!r}: use 'raise' or 'return'")
    with show_progress(progress):
        made: list[Flattening | MeshError | None] = [None] * len(given)
        arrays = [_check_arrays(mesh) for mesh in given]
        sound = [i for i, array in enumerate(arrays) if array is not None and boundary == "free"]
        together = flatten_batch([array for array in arrays if array is not None][: len(sound)], chosen)
        for i, result in zip(sound, together, strict=True):
            made[i] = result
        _warn_of_stretch(arrays, made)
        left = [i for i, result in enumerate(made) if result is None]
        for k, i in enumerate(left):
            with progress_part("alone", (k + 1) / len(left)):
                alone = _flatten_alone(given[i], chosen, boundary)
            if errors == "raise" and isinstance(alone, MeshError):
                raise type(alone)(f"mesh {i}: {alone}")
            made[i] = alone
    return [result for result in made if result is not None]


def _warn_of_stretch(meshes: Sequence[Arrays | None], maps: Sequence[Flattening | MeshError | None]) -> None:
    """Warn once of all valid maps that are stretched too much; other warnings are issued by `flatten`."""
    valid = [
        (i, *mesh, made.uv)
        for i, (mesh, made) in enumerate(zip(meshes, maps, strict=True))
        if mesh is not None and isinstance(made, Flattening) and not len(made.flipped)
    ]
    if not valid:
        return
    index, V, F, uv = zip(*valid, strict=True)
    vertices, faces = (Ragged.from_sizes([len(array) for array in arrays]) for arrays in (V, F))
    corner = np.ascontiguousarray(np.concatenate(F).T) + faces.repeat(vertices.start[:-1])
    area, _, _ = side_products(np.concatenate(V), corner)
    flat = signed_double_areas(complex_positions(np.concatenate(uv)), corner)
    stretched = np.array(index)[compute_least_stretch(area, flat, faces) > MOST_STRETCH]
    if len(stretched):
        warnings.warn(
            f"the maps of meshes {first_few(stretched)} have an L2 stretch of more than {MOST_STRETCH:g} (1 "
            "is best): parts of them are too small to be useful, such as the far end of a long tube; cut "
            "them, as igl_linabf.unwrap does",
            OutcomeWarning,
            stacklevel=stack_level(),
        )


def _check_arrays(mesh: object) -> Arrays | None:
    """Return V and F as arrays that can be concatenated, or None if they are malformed."""
    try:
        V, F = cast(Arrays, mesh)
        return vertex_array(V), face_array(F)
    except (TypeError, ValueError):  # `flatten` reports the error
        return None


def _flatten_alone(mesh: object, method: Method, boundary: BoundaryName) -> Flattening | MeshError:
    """Return the result of `flatten`, or the error that it raises."""
    try:
        V, F = cast(Arrays, mesh)
    except (TypeError, ValueError):
        return MeshError(f"a mesh is given as a {type(mesh).__name__}: pass its vertices and faces, (V, F)")
    try:
        return flatten(V, F, method=method, boundary=boundary)
    except MeshError as error:
        return error.with_traceback(None)  # free the arrays in the frames of the traceback


def flatten_batch(meshes: Sequence[Arrays], method: Method) -> list[Flattening | None]:
    """Flatten small disks with shared linear systems. The result is None for all other meshes."""
    made: list[Flattening | None] = [None] * len(meshes)
    if isinstance(method, Isometric):
        linear = flatten_batch(meshes, LinABF(solver=method.solver))
        for group in _group_small_meshes(meshes):
            found = [(i, result) for i in group if (result := linear[i]) is not None]
            chosen = [meshes[i] for i, _ in found]
            for k, result in iterate_isometric_maps(chosen, [result for _, result in found], method):
                made[found[k][0]] = result
        return made
    plain = isinstance(method, LinABF) and method.iterations == "auto" and method.safeguard
    if not (plain and isinstance(method, LinABF) and method.layout in ("auto", "boundary")):
        return made
    for results in map_in_threads(
        partial(_flatten_group, meshes, method=method), _group_small_meshes(meshes)
    ):
        for place, result in results:
            made[place] = result
        advance("layout", 0.1)
    return made


def _group_small_meshes(meshes: Sequence[Arrays]) -> Iterator[list[int]]:
    """Yield the indices of small meshes in groups that share a linear system."""
    group: list[int] = []
    faces = 0
    for i, (_, F) in enumerate(meshes):
        if len(F) <= MAX_SHARED_FACES:
            group.append(i)
            faces += len(F)
            if faces >= FACES_PER_SYSTEM:
                yield group
                group, faces = [], 0
    if group:
        yield group


def _flatten_group(
    meshes: Sequence[Arrays], group: list[int], method: LinABF
) -> list[tuple[int, Flattening]]:
    """Return the indices and results of the meshes of a group for which the shared solves suffice."""
    start = perf_counter()
    if len(group) < 2:
        return []
    disks, found = concatenate_sound_disks([meshes[i] for i in group])
    if disks is None or len(disks) < 2:
        return []
    try:
        with stopwatch("check", *STAGES) as seconds:
            seconds["check"] = perf_counter() - start
            batch = flatten_linear_batch(disks, method)
    except (NotPositiveDefiniteError, SingularSystemError):
        halves = np.array_split(found, 2)  # divide the group until the singular disk is alone
        parts = [_flatten_group(meshes, [group[i] for i in half], method) for half in halves]
        return parts[0] + parts[1]
    seconds["total"] = perf_counter() - start
    return _collect_batch_results(batch, [group[i] for i in found.tolist()], method, seconds)


def _collect_batch_results(
    batch: LinearBatch, places: list[int], method: LinABF, seconds: dict[str, float]
) -> list[tuple[int, Flattening]]:
    """Return the indices and results of a batch. Times are divided in proportion to the triangles."""
    vertices, faces = batch.disks.vertices.start.tolist(), batch.disks.faces.start.tolist()
    stepped, rows = batch.stepped, batch.stepped.state.problem.disks.rows.sizes.tolist()
    before, _, after = (residuals.T.tolist() for residuals in stepped.residuals)
    residual, inner = stepped.residuals.max(axis=1).T.tolist(), stepped.inner_steps.T.tolist()
    gap, ratio = batch.gap.tolist(), batch.ratio.tolist()
    crossed = set(find_crossed_loops(complex_positions(batch.uv), *batch.disks.boundary_loops).tolist())
    made = []
    for k in np.flatnonzero(batch.good).tolist():
        first, last = residual[k][0], residual[k][2]
        steps: tuple[Step, ...] = ()
        if first > method.tol:
            steps = Step("step", inner[k][0], 0, residual[k][1]), Step("chord", inner[k][1], 0, last)
        own, triangles = slice(vertices[k], vertices[k + 1]), slice(faces[k], faces[k + 1])
        solver, reached = batch.solver if rows[k] else "none", last <= method.tol
        outcome, message = determine_outcome(
            Findings("boundary", solver, ratio[k], NO_INDICES, last, converged=reached)
        )
        share = (faces[k + 1] - faces[k]) / faces[-1]
        result = Flattening(
            uv=batch.uv[own],
            F=batch.F[triangles],
            angles=batch.angles[triangles],
            method=method.name,
            outcome=outcome,
            message=message,
            flipped=NO_INDICES.copy(),
            before=Residuals(*before[k]),
            after=Residuals(*after[k]),
            seconds={stage: share * value for stage, value in seconds.items()},
            report=FlatteningReport(
                attempts=(Attempt("linear step", Status.GOOD, 0, last, ""),),
                steps=steps,
                gap=gap[k],
                layout="boundary",
                solver=stepped.state.solver_name if steps else "none",
                layout_solver=solver,
            ),
        )
        if k in crossed:
            result = report_overlaps(result, find_overlapping_pairs(result.uv, result.F))
        made.append((places[k], result))
    return made
