"""Many meshes at once: their disks side by side in one system, and alone what needs more than that."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import partial
from time import perf_counter
from typing import cast

import numpy as np
from numpy.typing import ArrayLike

from .._runtime import Progress, advance, in_threads, part, reporting, stopwatch, timed
from .._types import FloatArray, IntArray
from ..angles import AngleProblem, Step, constraints_of, initial_estimate, opened, rows_of, step_and_chord
from ..errors import MeshError, SingularSystemError
from ..layouts import GAP, flat_disks
from ..linalg import SMALL, NotPositiveDefiniteError, Solvers
from ..surface import Disks, coordinates, face_array, side_by_side, vertex_array
from .isometric_together import lengthened
from .methods import ONE_SYSTEM_RTOL, STAGES, Isometric, LinABF, Method, method_of
from .outcome import judge
from .result import Flattening, Residuals, Rung, Status
from .shapes import BoundaryName
from .verbs import flatten

LARGE = 10_000  # triangles from which a mesh is flattened alone: in company it would take as long
AT_ONCE = 40_000  # triangles in company: fewer calls from Python, and still in the processor's caches

Arrays = tuple[FloatArray, IntArray]


def flatten_many(
    meshes: Sequence[tuple[ArrayLike, ArrayLike]],
    method: str | Method = "linabf",
    *,
    boundary: BoundaryName = "free",
    progress: Progress = None,
) -> list[Flattening | MeshError]:
    """Flatten many meshes at once: what a loop of `flatten` returns, in less time.

    Small disks go side by side into linear systems, as they do not touch: a system is assembled, analysed
    and factored once, and each disk has its own steps, residuals and outcome. Threads work at several
    systems at a time, as many as there are cores or as OMP_NUM_THREADS says. Isometric maps begin with these.
    What needs more than linear ABF's two solves, or begins far from an isometry, disks with holes, large
    meshes, shaped boundaries and other methods are flattened one by one.

    Parameters
    ----------
    meshes : sequence of (V, F)
        As in `flatten`: vertex positions (#V, 3) float and triangles (#F, 3) int of each mesh.
    method : str or method object
        As in `flatten`.
    boundary : {"free", "circle", "circles", "rectangle"}
        As in `flatten`, for all meshes; the corners of rectangles are found.
    progress : callable or False, optional
        As in `flatten`.

    Returns
    -------
    list of Flattening or MeshError
        In the order of `meshes`. Maps and angles are those of `flatten` to 1e-10, and outcomes and ladders
        are the same. A mesh that `flatten` refuses has the `MeshError` in its place. The `seconds` of
        meshes that were solved together are shared out by their triangles.

    Raises
    ------
    ValueError
        There is no method of that name.

    Examples
    --------
    >>> import igl
    >>> V, F = igl.icosahedron()
    >>> disk, closed = flatten_many([(V, F[1:]), (V, F)])
    >>> disk.outcome.value, str(closed)[:18]
    ('valid', 'the mesh is closed')
    """
    chosen, given = method_of(method), list(meshes)
    with reporting(progress):
        made: list[Flattening | MeshError | None] = [None] * len(given)
        arrays = [_arrays(mesh) for mesh in given]
        sound = [i for i, array in enumerate(arrays) if array is not None and boundary == "free"]
        together = flatten_together([array for array in arrays if array is not None][: len(sound)], chosen)
        for i, result in zip(sound, together, strict=True):
            made[i] = result
        left = [i for i, result in enumerate(made) if result is None]
        for k, i in enumerate(left):
            with part("alone", (k + 1) / len(left)):
                made[i] = _alone(given[i], chosen, boundary)
    return [result for result in made if result is not None]


def _arrays(mesh: object) -> Arrays | None:
    """V and F in the form in which they are put together, if they are that far sound."""
    try:
        V, F = cast(Arrays, mesh)
        return vertex_array(V), face_array(F)
    except (TypeError, ValueError):  # what is wrong is said by `flatten`
        return None


def _alone(mesh: object, method: Method, boundary: BoundaryName) -> Flattening | MeshError:
    """What `flatten` returns or raises."""
    try:
        V, F = cast(Arrays, mesh)
    except (TypeError, ValueError):
        return MeshError(f"a mesh is given as a {type(mesh).__name__}: pass its vertices and faces, (V, F)")
    try:
        return flatten(V, F, method, boundary=boundary)
    except MeshError as error:
        return error.with_traceback(None)  # which would keep the arrays of all its frames


def flatten_together(meshes: Sequence[Arrays], method: Method) -> list[Flattening | None]:
    """Flatten small disks side by side; None for each mesh that is to be flattened alone."""
    made: list[Flattening | None] = [None] * len(meshes)
    if isinstance(method, Isometric):
        linear = flatten_together(meshes, LinABF(solver=method.solver))
        for group in _groups(meshes, range(len(meshes))):
            found = [(i, result) for i in group if (result := linear[i]) is not None]
            chosen = [meshes[i] for i, _ in found]
            for k, result in lengthened(chosen, [result for _, result in found], method):
                made[found[k][0]] = result
        return made
    plain = isinstance(method, LinABF) and method.iterations == "auto" and method.safeguard
    if not (plain and isinstance(method, LinABF) and method.layout in ("auto", "boundary")):
        return made
    places: Sequence[int] = range(len(meshes))
    for _ in range(2):  # those with slivers go together the second time
        thin: list[int] = []
        for results, others in in_threads(partial(_group, meshes, method=method), _groups(meshes, places)):
            for place, result in results:
                made[place] = result
            thin += others
            advance("together", 0.1)
        places = thin
    return made


def _groups(meshes: Sequence[Arrays], places: Sequence[int]) -> Iterator[list[int]]:
    """Which of the meshes at these places go together: none that is large, and those of one solver."""
    for least, most in ((0, SMALL), (SMALL + 1, LARGE)):
        group: list[int] = []
        faces = 0
        for i in places:
            size = len(meshes[i][1])
            if least <= size <= most:
                group.append(i)
                faces += size
                if faces >= AT_ONCE:
                    yield group
                    group, faces = [], 0
        if group:
            yield group


Results = tuple[list[tuple[int, Flattening]], list[int]]


def _group(meshes: Sequence[Arrays], group: list[int], method: LinABF) -> Results:
    """The places and results of those that come out well together, and the places of those with slivers."""
    if len(group) < 2:
        return [], []
    start = perf_counter()
    disks, found = side_by_side([meshes[i] for i in group])
    if disks is None or len(disks) < 2:
        return [], []
    try:
        with stopwatch("check", *STAGES) as seconds:
            seconds["check"] = perf_counter() - start
            results, thin = _flat(disks, method)
    except (NotPositiveDefiniteError, SingularSystemError):
        halves = np.array_split(found, 2)  # until it is alone
        parts = [_group(meshes, [group[i] for i in half], method) for half in halves]
        return parts[0][0] + parts[1][0], parts[0][1] + parts[1][1]
    seconds["total"] = perf_counter() - start
    for k, result in results:
        share = float(disks.faces.sizes[k] / disks.faces.start[-1])
        result.seconds.update({stage: share * value for stage, value in seconds.items()})
    return [(group[found[k]], result) for k, result in results], [group[found[k]] for k in thin]


def _flat(disks: Disks, method: LinABF) -> Results:
    """Disks by one system, the ladder's first rung; the places of those for which that is enough.

    And of those with slivers, if not all have some.
    """
    solvers, vertices, faces = Solvers(method.solver), disks.vertices, disks.faces
    with timed("estimate"):
        alpha, caps = opened(np.arctan2(disks.double_area, disks.dot))
        estimate = initial_estimate(disks.topology, alpha, method.threshold)
    with timed("assembly"):
        problem = AngleProblem(constraints_of(disks.topology), estimate, solvers)
    stepped = step_and_chord(problem, disks, method.rtol or ONE_SYSTEM_RTOL, method.tol)
    if stepped is None:
        return [], []
    with timed("layout"):
        flat = flat_disks(disks, problem.constraints, stepped.at, solvers)
    if flat is None:
        return [], []
    good = stepped.good & ~flat.flipped & (flat.gap <= GAP)
    good[np.searchsorted(faces.start, caps, side="right") - 1] = False  # that is to be warned of
    rows = rows_of(problem.constraints, disks)
    before, _, after = (families.T.tolist() for families in stepped.families)
    triangles = disks.topology.corner.T - faces.spread(vertices.start[:-1])[:, None]
    angles, uv = np.ascontiguousarray(stepped.at.alpha.T), coordinates(flat.z)
    residual, inner = stepped.families.max(axis=1).T.tolist(), stepped.inner_steps.T.tolist()
    gap, ratio = flat.gap.tolist(), flat.ratio.tolist()
    nothing, made = np.empty(0, dtype=np.int64), []
    for k in np.flatnonzero(good).tolist():
        first, last = residual[k][0], residual[k][2]
        steps: tuple[Step, ...] = ()
        if first > method.tol:
            steps = Step("step", inner[k][0], 0, residual[k][1]), Step("chord", inner[k][1], 0, last)
        has_rows = bool(rows.sizes[k])
        solver = flat.solver if has_rows else "none"
        reached = last <= method.tol
        outcome, message = judge(ratio[k], "boundary", solver, nothing, last, nothing, converged=reached)
        result = Flattening(
            uv=uv[vertices.start[k] : vertices.start[k + 1]],
            F=triangles[faces.start[k] : faces.start[k + 1]],
            angles=angles[faces.start[k] : faces.start[k + 1]],
            method=method.name,
            outcome=outcome,
            message=message,
            flipped=nothing,
            ladder=(Rung("linear step", Status.GOOD, 0, last, ""),),
            steps=steps,
            before=Residuals(*before[k]),
            after=Residuals(*after[k]),
            gap=gap[k],
            layout="boundary",
            solver=stepped.how if steps else "none",
            layout_solver=solver,
        )
        made.append((k, result))
    return made, np.flatnonzero(stepped.thin).tolist()
