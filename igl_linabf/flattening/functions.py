"""The public functions, which check the input, run a method, and return the map or the complete result."""

from __future__ import annotations

import sys
import warnings
from collections.abc import Callable
from dataclasses import replace
from time import perf_counter
from typing import TYPE_CHECKING, Literal, get_args

import numpy as np
from numpy.typing import ArrayLike

from .._runtime import Progress, advance, show_progress
from .._types import FloatArray
from ..errors import (
    MeshError,
    MeshWarning,
    OutcomeWarning,
    first_few,
    format_count,
    stack_level,
    takes_vertices_and_faces,
)
from ..layouts import LayoutName
from ..linalg import SolverName
from ..measures import Distances, find_overlapping_pairs_of_chart, measure_quality
from ..surface import (
    Mesh,
    Pins,
    Ragged,
    RepairedDisk,
    Submesh,
    complex_positions,
    find_flipped_faces,
    map_direction,
    parse_direction,
    planar_mesh,
    real_coordinates,
    repair_disk,
    scale_to_unit_size,
    scatter_to_input,
    shape_is_pinned,
    signed_double_areas,
    validate_pins,
)
from .boundary_shapes import BoundaryName, resolve_shape
from .constants import ABF_TOL, MOST_STRETCH, TOL
from .methods import (
    ABF,
    AREA_WEIGHT,
    ISOMETRIC_TOL,
    Isometric,
    Iterations,
    LinABF,
    Method,
    MethodOptions,
    resolve_method,
)
from .result import MAX_COUNTED, Flattening, Guarantee, Outcome, report_overlaps

if sys.version_info >= (3, 11):
    from typing import Unpack
elif TYPE_CHECKING:
    from typing_extensions import Unpack

Fit = Literal["area", "lengths"]

FIT_SOURCES = 250  # number of vertices from which distances are measured for fit="lengths"
MIN_UP_LENGTH = 0.01  # turn the map if the mean image of the unit direction `up` is at least this long
MIRRORED_SHARE = 0.9  # pins are mirrored if at least this share of their triangles is reversed
MOST_PINNED_TRIANGLES = 2000  # check the orientation of at most this many random triangles of pins


@takes_vertices_and_faces
def linabf(
    V: ArrayLike,
    F: ArrayLike,
    b: ArrayLike | None = None,
    bc: ArrayLike | None = None,
    *,
    iterations: Iterations = "auto",
    layout: LayoutName = "auto",
    outer: int | None = None,
    boundary: BoundaryName | ArrayLike = "free",
    corners: ArrayLike | None = None,
    rtol: float | None = None,
    tol: float = TOL,
    threshold: float = 1.0,
    safeguard: bool = True,
    guarantee: Guarantee | None = None,
    solver: SolverName = "auto",
) -> FloatArray:
    """Compute the linear angle based parameterization (Zayer, Levy, Seidel, SGP 2007).

    Parameters
    ----------
    V : (#V, 3) float
        Vertex positions.
    F : (#F, 3) int
        Oriented triangles of one disk, with or without holes. Holes are not cut.
    b, bc : (#b,) int and (#b, 2) float, optional
        Two or more pinned vertices and their positions, as in `igl.lscm`. Two pins determine the placement of
        the map; more pins are constraints of the least-squares layout. Without pins, the map is scaled to the
        area of the surface, centred, and turned to its principal axes.
    iterations : int or "auto"
        1 is the single linear step of the paper. k runs up to k steps of the active set (section 6), each
        linearised at the angles of the previous step. The steps end early if the residual is at most `tol`.
        "auto" is one step and a second solve with the same system. If a step was limited, the boundary does
        not close, or a triangle flips, at most 12 steps of the active set follow, and corrections in the
        conformal metric. If triangles still flip, converged ABF follows. On a mesh with holes, the second
        solve is a step, which also closes the loops of the holes (docs/holes.md).
    layout : {"auto", "boundary", "least-squares", "greedy"}
        The method that turns angles into coordinates; see `igl_linabf.layouts.layout`.
    outer : int, optional
        A vertex of the outer boundary loop; all other loops are holes. By default, the loop that
        encloses all other loops is the outer loop.
    boundary : {"free", "circle", "circles", "rectangle"} or (#V,) float
        "circle": the outer loop lies on a circle; "circles": all holes do, too. "rectangle": the outer loop
        is a rectangle. An array contains the angle of the map at each boundary vertex, in radians: pi is
        straight, pi / 2 a right angle, and NaN free; it is NaN at interior vertices. See docs/boundaries.md.
    corners : (4,) int, optional
        The boundary vertices at the corners of the rectangle. By default, the vertices where the boundary
        turns most.
    rtol : float, optional
        Relative residual at which conjugate gradients stop. The default is 0.1 for the two solves of "auto",
        0.03 for the steps that follow these solves, and 0.01 otherwise. With a given `rtol`, there are no
        corrections in the conformal metric.
    tol : float
        Tolerance of the angle constraints, in radians.
    threshold : float
        If the angles around an interior vertex differ from 2 pi by more than this many radians, they are
        scaled to sum to 2 pi (section 4.2).
    safeguard : bool
        Keep all angles positive: scale the estimated angles to sum to pi in each triangle, and limit the step
        of each triangle. False is the unmodified scheme of the paper.
    guarantee : {"injective"}, optional
        If triangles flip with all methods of the default, compute a map without flipped triangles by SLIM,
        with more distortion.
    solver : {"auto", "cholmod", "direct"}
        "auto" solves by conjugate gradients, preconditioned by the Cholesky factor of one Laplacian.
        "cholmod" uses CHOLMOD for this factor, which requires scikit-sparse. "direct" factors the whole
        system.

    Returns
    -------
    uv : (#V, 2) float64
        NaN at vertices that belong to no face.

    Raises
    ------
    MeshError
        The surface is not one oriented manifold piece with a boundary and without handles, a face is
        degenerate, `outer` is not on a boundary loop, the pins are not two or more different vertices, or no
        flat map has such a `boundary`.

    Warns
    -----
    OutcomeWarning
        The map has flipped triangles or overlaps itself; `flatten` returns the same map with its outcome and
        residuals.

    Examples
    --------
    >>> import igl
    >>> V, F = igl.icosahedron()
    >>> linabf(V, F[1:]).shape
    (12, 2)
    """
    method = LinABF(iterations, layout, rtol, tol, threshold, safeguard, guarantee, solver)
    result = flatten(V, F, b, bc, method=method, outer=outer, boundary=boundary, corners=corners)
    return _warn_if_bad(result).uv


@takes_vertices_and_faces
def abf(
    V: ArrayLike,
    F: ArrayLike,
    b: ArrayLike | None = None,
    bc: ArrayLike | None = None,
    *,
    layout: LayoutName = "auto",
    outer: int | None = None,
    boundary: BoundaryName | ArrayLike = "free",
    corners: ArrayLike | None = None,
    tol: float = ABF_TOL,
    threshold: float = 1.0,
    guarantee: Guarantee | None = None,
    solver: SolverName = "auto",
) -> FloatArray:
    """Compute the converged angle based flattening: the flat mesh with angles closest to the surface.

    The sum ((alpha - alpha_0) / alpha_0)^2 is minimised (Sheffer, de Sturler 2001) subject to all
    constraints, by steps of linear ABF relative to the initial estimate alpha_0. If the steps do not
    converge, slower steps are used that stay close to flat meshes, with a hundredth of alpha_0 as a lower
    bound of every angle.

    Parameters
    ----------
    V, F, b, bc, layout, outer, boundary, corners : see `linabf`
        As in `linabf`.
    tol : float
        The iterations end when the largest residual, and the largest relative change of an angle by another
        step, are at most `tol`, which is at least 1e-10. The iterations also end if all further steps would
        decrease the sum by less than the share 16 tol^2. At 1e-4, the mean angle distortion F/3nt is accurate
        to five digits, or to 1e-10. Maps whose areas differ by 20 orders of magnitude or more are less
        accurate.
    threshold, guarantee, solver : see `linabf`
        As in `linabf`.

    Returns
    -------
    uv : (#V, 2) float64
        NaN at vertices that belong to no face.

    Raises
    ------
    MeshError
        As in `linabf`.

    Warns
    -----
    OutcomeWarning
        The iterations did not converge, or the map has flipped triangles or overlaps itself.

    Examples
    --------
    >>> import igl
    >>> V, F = igl.icosahedron()
    >>> abf(V, F[1:], tol=1e-10).shape
    (12, 2)
    """
    method = ABF(layout, tol, threshold, guarantee, solver)
    result = flatten(V, F, b, bc, method=method, outer=outer, boundary=boundary, corners=corners)
    if result.outcome is Outcome.NOT_CONVERGED:
        warnings.warn(result.message, OutcomeWarning, stacklevel=stack_level())
    return _warn_if_bad(result).uv


@takes_vertices_and_faces
def isometric(
    V: ArrayLike,
    F: ArrayLike,
    b: ArrayLike | None = None,
    bc: ArrayLike | None = None,
    *,
    outer: int | None = None,
    weight: float = AREA_WEIGHT,
    tol: float = ISOMETRIC_TOL,
    solver: SolverName = "auto",
) -> FloatArray:
    """Compute the map that preserves lengths as well as possible, without flipped triangles.

    `Isometric` defines the energy that is minimised. Pins are met as well as possible without flips.

    Parameters
    ----------
    V, F, b, bc, outer : see `linabf`
        As in `linabf`.
    weight, tol, solver : see `Isometric`
        As in `Isometric`.

    Returns
    -------
    uv : (#V, 2) float64
        NaN at vertices that belong to no face.

    Raises
    ------
    MeshError
        As in `linabf`.
    ValueError
        An option has a value that is not allowed.

    Warns
    -----
    OutcomeWarning
        No map without flipped triangles was found to start from, or the map overlaps itself or is stretched
        too much to be useful.

    Examples
    --------
    >>> import igl
    >>> V, F = igl.icosahedron()
    >>> isometric(V, F[1:], weight=4).shape
    (12, 2)
    """
    method = Isometric(weight, tol, solver)
    return _warn_if_bad(flatten(V, F, b, bc, method=method, outer=outer)).uv


@takes_vertices_and_faces
def lscm(V: ArrayLike, F: ArrayLike, b: ArrayLike | None = None, bc: ArrayLike | None = None) -> FloatArray:
    """Run `igl.lscm` with checked input, and with two distant pins by default.

    Parameters
    ----------
    V, F, b, bc : array_like
        As in `linabf`. The default pins are two boundary vertices half the length of the loop apart; among
        all such pairs, the pair with the largest distance. The map is then scaled, centred and turned as in
        `linabf`.

    Returns
    -------
    uv : (#V, 2) float64
        NaN at vertices that belong to no face.

    Raises
    ------
    MeshError
        As in `linabf`.

    Warns
    -----
    OutcomeWarning
        The map has flipped triangles or overlaps itself.

    Examples
    --------
    >>> import igl
    >>> V, F = igl.icosahedron()
    >>> lscm(V, F[1:], [0, 1], [[0, 0], [1, 0]]).shape
    (12, 2)
    """
    return _warn_if_bad(flatten(V, F, b, bc, method="lscm")).uv


@takes_vertices_and_faces
def linabf_angles(
    V: ArrayLike,
    F: ArrayLike,
    *,
    iterations: Iterations = "auto",
    outer: int | None = None,
    rtol: float | None = None,
    tol: float = TOL,
    threshold: float = 1.0,
    safeguard: bool = True,
    guarantee: Guarantee | None = None,
    solver: SolverName = "auto",
) -> FloatArray:
    """Compute the target angles of `linabf`, which `layout` turns into a map.

    Parameters
    ----------
    V, F, iterations, outer, rtol, tol, threshold, safeguard, guarantee, solver : see `linabf`
        As in `linabf`.

    Returns
    -------
    angles : (#F, 3) float64
        Radians, `angles[t, k]` at vertex `F[t, k]`, as `igl.internal_angles` returns them.

    Raises
    ------
    MeshError
        As in `linabf`.

    Examples
    --------
    >>> import igl
    >>> V, F = igl.icosahedron()
    >>> angles = linabf_angles(V, F[1:], iterations=12)
    >>> bool(abs(angles.sum(axis=1) - 3.141592653589793).max() < 1e-12)
    True
    """
    method = LinABF(iterations, "auto", rtol, tol, threshold, safeguard, guarantee, solver)
    result = flatten(V, F, method=method, outer=outer)
    # do not warn of overlaps of the map, because only angles are returned
    return (result if result.outcome is Outcome.OVERLAPPING else _warn_if_bad(result)).angles


def _warn_if_bad(result: Flattening) -> Flattening:
    """Warn if the outcome is bad, because callers return only a part of the result."""
    if not result.outcome.good:
        warnings.warn(result.message, OutcomeWarning, stacklevel=stack_level())
    return result


@takes_vertices_and_faces
def flatten(
    V: ArrayLike,
    F: ArrayLike,
    b: ArrayLike | None = None,
    bc: ArrayLike | None = None,
    *,
    method: str | Method = "linabf",
    outer: int | None = None,
    boundary: BoundaryName | ArrayLike = "free",
    corners: ArrayLike | None = None,
    up: ArrayLike | None = None,
    fit: Fit = "area",
    clean: bool = False,
    progress: Progress = None,
    **options: Unpack[MethodOptions],
) -> Flattening:
    """Flatten a disk, with or without holes; return the map with residuals, steps, times and outcome.

    Parameters
    ----------
    V : (#V, 3) float
        Vertex positions.
    F : (#F, 3) int
        Oriented triangles of one disk, with or without holes. Holes are not cut.
    b, bc : (#b,) int and (#b, 2) float, optional
        Two or more pinned vertices and their positions, as in `igl.lscm`. Two pins determine the placement of
        the map. More pins are constraints of the least-squares layout, of "lscm" and "dncp", and of
        "isometric", which meets them as well as possible without flips. "scp" takes two pins.
    method : str or method object
        "linabf": linear angle based parameterization. "abf": its converged form. "isometric": a compromise
        that also preserves areas. For comparison: "one-step-abf++", a single Newton step of ABF++; "lscm",
        `igl.lscm`; "scp", the spectral `igl.spectra.lscm`, which needs no pins; "dncp", the energy of LSCM
        from cotangents. A name stands for the method with its default options. To set options, pass them
        as keywords, or an object, such as `igl_linabf.LinABF(iterations=1)` or `igl_linabf.ABF(tol=1e-7)`.
    outer : int, optional
        A vertex of the outer boundary loop; all other loops are holes. By default, the loop that
        encloses all other loops is the outer loop.
    boundary : {"free", "circle", "circles", "rectangle"} or (#V,) float
        "circle": the outer loop lies on a circle; "circles": all holes do, too. "rectangle": the outer loop
        is a rectangle. An array contains the angle of the map at each boundary vertex, in radians: pi is
        straight, pi / 2 a right angle, and NaN free; it is NaN at interior vertices. Only for "linabf" and
        "abf"; the other methods have a free boundary. See docs/boundaries.md.
    corners : (4,) int, optional
        The boundary vertices at the corners of the rectangle. By default, the vertices where the boundary
        turns most. Without pins, the side from the first to the second corner is at the bottom.
    up : (3,) float, optional
        Direction in space that points up in the map, on average over the surface; (0, 0, 1) turns the map of
        a face upright. It cannot be combined with pins or a rectangle, which determine the placement of the
        map. By default, the map is turned to its principal axes.
    fit : {"area", "lengths"}
        The scale of a map without pins. "area": the map has the area of the surface. "lengths": the mean
        error of distances within 7 rings is minimal (`distance_error`), which takes half a second.
    clean : bool
        Repair the surface first, as `igl_linabf.clean` does. This removes faces between coincident
        neighbours, which get the same position in the map, and opens other faces without area. The result
        has a row of `uv` for each given vertex; its `F` lacks the removed faces.
    progress : callable or False, optional
        Called with the name of a stage and the completed fraction, from 0 to 1. An exception that it raises
        ends the computation. By default, a bar is shown on a terminal after two seconds; False shows nothing.
    **options
        Options of the method, such as `guarantee="injective"` for "linabf" or `weight=3` for "isometric".

    Returns
    -------
    Flattening
        The map `uv`, its target angles, residuals, steps, times and outcome. A map with flipped triangles, or
        one that overlaps itself, is returned without an error or a warning: check `outcome`.

    Raises
    ------
    MeshError
        The surface is not one oriented manifold piece with a boundary and without handles; a face is
        degenerate; `outer` is not on a boundary loop; the pins are not two or more different vertices, or are
        mirrored, such as a boundary that is pinned clockwise; or no flat map has such a `boundary`. The
        message then suggests valid angles. With `clean`: the repair cuts the surface apart at a vertex, which
        would have several positions in the map.
    ValueError
        The name of the method, of one of its options, of the `boundary` or of the `fit` is unknown, or the
        method cannot shape the boundary. `up` is not a direction, or is combined with another placement of
        the map. `fit` is combined with pins, which determine the scale.

    Warns
    -----
    MeshWarning
        `up` has no direction on the surface, and the map is not turned; or faces are at the limit of double
        precision, and rounding would flip them if the map were turned or scaled.
    OutcomeWarning
        The map is stretched too much to be useful, such as the map of a long tube; `unwrap` cuts the surface.

    Examples
    --------
    >>> import igl
    >>> V, F = igl.icosahedron()
    >>> result = flatten(V, F[1:])
    >>> result.outcome.value, len(result.flipped), result.report.layout
    ('valid', 0, 'boundary')

    Two neighbours at the same position:

    >>> V, F = [[0, 0, 0], [1, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 4], [1, 2, 4], [2, 3, 4]]
    >>> result = flatten(V, F, clean=True)
    >>> result.uv[1].tolist() == result.uv[2].tolist(), len(result.F)
    (True, 2)
    """
    if fit not in get_args(Fit):
        raise ValueError(f"fit is {fit!r}: use 'area' or 'lengths'")
    if fit == "lengths" and b is not None:
        raise ValueError("the pins set the scale of the map: leave out fit, or pin nothing")
    method = resolve_method(method, options)
    if not clean:
        return flatten_mesh(
            lambda: planar_mesh(V, F, outer), method, b, bc, progress, boundary, corners, up, fit
        )
    disk = repair_disk(V, F)
    made = flatten_mesh(
        lambda: planar_mesh(
            disk.cleaned.V,
            disk.cleaned.F,
            None if outer is None else int(disk.convert_vertices("outer", [outer])[0]),
        ),
        method,
        None if b is None else disk.convert_vertices("b", b),
        bc,
        progress,
        boundary if isinstance(boundary, str) else disk.gather_at_vertices(boundary),
        None if corners is None else disk.convert_vertices("corners", corners),
        up,
        fit,
    )
    return _restore_given_vertices(made, disk, placed=b is not None)


def _restore_given_vertices(made: Flattening, disk: RepairedDisk, placed: bool) -> Flattening:
    """Convert a result of a repaired disk to the original vertices. If `placed`, pins determine the scale."""
    origin, used = disk.cleaned.origin, disk.row >= 0
    uv = np.full((len(disk.row), 2), np.nan)
    uv[used] = np.ldexp(made.uv[disk.row[used]], 0 if placed else -disk.cleaned.power)
    return replace(
        made,
        uv=uv,
        F=origin[made.F],
        holes=tuple(replace(hole, vertex=int(origin[hole.vertex])) for hole in made.holes),
        report=replace(made.report, corners=origin[made.report.corners], repairs=disk.cleaned.repairs),
    )


def flatten_mesh(
    checked: Callable[[], Mesh],
    method: str | Method,
    b: ArrayLike | None,
    bc: ArrayLike | None,
    progress: Progress,
    boundary: BoundaryName | ArrayLike = "free",
    corners: ArrayLike | None = None,
    up: ArrayLike | None = None,
    fit: Fit = "area",
) -> Flattening:
    """Flatten the mesh that `checked` returns, with the options of `flatten`."""
    start, chosen = perf_counter(), resolve_method(method)
    with show_progress(progress):
        mesh = checked()
        pinned = validate_pins(b, bc, mesh.vertices, mesh.n_given)
        shape = resolve_shape(mesh, boundary, corners)
        if shape.name != "free" and not chosen.shapes:
            raise ValueError(f"the method {chosen.name!r} has a free boundary: use 'linabf' or 'abf'")
        if shape.name != "free" and shape_is_pinned(pinned):
            raise MeshError(
                f"{format_count(len(pinned[0]), 'vertex')} {'is' if len(pinned[0]) == 1 else 'are'} "
                "pinned, and the boundary has a shape: pin two vertices to "
                "place the whole map, or leave the boundary free"
            )
        upwards = None if up is None else _check_up_direction(up, pinned is not None, shape.name)
        seconds = {"check": perf_counter() - start}
        advance("check", 0.05)
        made = chosen.run(mesh, pinned, shape) if shape.name != "free" else chosen.run(mesh, pinned)
        if fit == "lengths":
            begin = perf_counter()
            surface = Submesh.from_arrays(mesh.V, mesh.faces)
            scale = Distances.measure_within_rings(surface, most=FIT_SOURCES).find_best_scale(made.uv)
            made = _replace_map(mesh, made, made.uv * scale, "scaled")
            seconds["fit"] = perf_counter() - begin
    if shape_is_pinned(pinned) and made.outcome in (Outcome.FLIPPED, Outcome.NOT_CONVERGED):
        _check_not_mirrored(mesh, pinned)
    if made.outcome.good:
        _warn_if_stretched(mesh, made.uv)
        made = report_overlaps(made, find_overlapping_pairs_of_chart(mesh.topology, made.uv, MAX_COUNTED))
    if upwards is not None:
        made = _replace_map(mesh, made, _turn_upright(mesh, made.uv, upwards), "turned")
    uv = scatter_to_input(made.uv, mesh.vertices, mesh.n_given)
    seconds |= {**made.seconds, "total": perf_counter() - start}
    F = made.F if len(mesh.vertices) == mesh.n_given else mesh.vertices[made.F]
    return replace(made, uv=uv, F=F, seconds=seconds)


def _check_not_mirrored(mesh: Mesh, pinned: Pins) -> None:
    """Raise an error if only a mirrored map meets the pins, such as a boundary pinned clockwise."""
    index, positions = pinned
    three = np.random.default_rng(0).integers(len(index), size=(MOST_PINNED_TRIANGLES, 3)).T
    of_map, of_pins = (
        np.sign(signed_double_areas(z, three))
        for z in (complex_positions(LinABF().run(mesh, None).uv)[index], complex_positions(positions))
    )
    turned, size = np.count_nonzero(of_map * of_pins < 0), np.count_nonzero(of_map * of_pins)
    if size and turned >= MIRRORED_SHARE * size:
        raise MeshError(
            f"the pins of vertices {first_few(mesh.vertices[index])} are mirrored: they run clockwise where "
            "the boundary of the map runs counterclockwise, and all triangles would flip; mirror the "
            "positions, as bc * [1, -1], or reverse the faces, F[:, ::-1]"
        )


def compute_least_stretch(area: FloatArray, flat: FloatArray, faces: Ragged) -> FloatArray:
    """Return the L2 stretch that each map would have if no angle changed.

    This stretch depends only on the areas of the triangles, on the surface and in the map.
    """
    with np.errstate(all="ignore"):
        return np.asarray(np.sqrt(faces.sum(area * (area / flat)) * faces.sum(flat)) / faces.sum(area))


def _warn_if_stretched(mesh: Mesh, uv: FloatArray) -> None:
    """Warn if a valid map is useless because most of the surface shrinks to a point."""
    corner, area = mesh.topology.corner, mesh.double_area
    flat = signed_double_areas(complex_positions(scale_to_unit_size(uv)), corner)
    if not compute_least_stretch(area, flat, Ragged.from_sizes([len(area)])) > MOST_STRETCH:
        return
    n = len(mesh.V)
    surface = Submesh(mesh.V, corner.T, np.arange(corner.shape[1]), np.arange(n), n)
    stretch = measure_quality(surface, uv, overlaps=0).stretch_l2
    warnings.warn(
        f"the map has an L2 stretch of {stretch:,.4g} (1 is best): parts of the surface are too small to "
        "be useful, such as the far end of a long tube; cut the mesh, as igl_linabf.unwrap does",
        OutcomeWarning,
        stacklevel=stack_level(),
    )


def _check_up_direction(up: ArrayLike, has_pins: bool, boundary: str) -> FloatArray:
    """Check the direction `up`; raise an error if other options already determine the rotation of the map."""
    if has_pins or boundary == "rectangle":
        what = "pins" if has_pins else "the rectangle's corners"
        raise ValueError(f"up does not go together with {what}, which place the map: omit one of them")
    return parse_direction(up, "up")


def _replace_map(mesh: Mesh, made: Flattening, uv: FloatArray, how: str) -> Flattening:
    """Replace the map of a result by `uv`, unless rounding would change which faces are flipped."""
    changed = np.setxor1d(find_flipped_faces(complex_positions(uv), mesh.topology.corner), made.flipped)
    if not len(changed):
        return replace(made, uv=uv)
    warnings.warn(
        f"the map is not {how}: faces {first_few(changed)} are at the end of double precision, and "
        "rounding would flip them; cut the mesh, as igl_linabf.unwrap does",
        MeshWarning,
        stacklevel=stack_level(),
    )
    return made


def _turn_upright(mesh: Mesh, uv: FloatArray, up: FloatArray) -> FloatArray:
    """Turn the map so that the direction `up` points up, on average."""
    z = complex_positions(uv)
    along, area = map_direction(mesh.V, z, mesh.topology.corner.T, up)
    mean = complex(along @ area / area.sum())
    size = np.sqrt(np.abs(signed_double_areas(z, mesh.topology.corner)).sum() / area.sum() / 2)
    if not abs(mean) > MIN_UP_LENGTH * size:
        said = f"up is {up.tolist()}, which points nowhere on this surface: the map is not turned"
        warnings.warn(f"{said}; give another direction", MeshWarning, stacklevel=stack_level())
        return uv
    return real_coordinates(z * (1j * mean.conjugate() / abs(mean)))
