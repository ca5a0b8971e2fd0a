"""Move overlapping parts of a map apart without a cut, using libigl's SCAF."""

import warnings
from dataclasses import replace

import igl
import igl.triangle
import numpy as np
from numpy.typing import ArrayLike

from ..._runtime import Arrays, run_as_child_process, run_in_child_process
from ..._types import FloatArray
from ...errors import (
    FallbackWarning,
    MeshError,
    OutcomeWarning,
    first_few,
    format_count,
    is_number,
    stack_level,
)
from ...flattening import Flattening, Outcome
from ...layouts import embed_in_circle
from ...linalg import Solvers
from ...measures import find_overlapping_pairs_of_chart
from ...surface import (
    Submesh,
    Topology,
    check_planar,
    complex_positions,
    find_flipped_faces,
    real_coordinates,
    signed_double_areas,
)
from .tips import MapDistortion

SCAF_SECONDS = 300.0  # time limit of SCAF, seconds, because SCAF hangs on some maps
SCAF_SECONDS_PER_FACE = 1e-2  # seconds added to that time limit for each face
SCAF_ITERATIONS = 50  # default number of iterations of SCAF
# SCAF may increase the L2 stretch and the conformal distortion at most by this factor.
MAX_SCAF_STRETCH_FACTOR = 1.2
MIN_SCAF_AREA = 1e-14  # reject maps with a triangle below this share of the area: the energy overflows

SCAF = "igl's SCAF"


def make_bijective(
    uv: ArrayLike, F: ArrayLike, *, iterations: int = SCAF_ITERATIONS, timeout: float = 600.0
) -> FloatArray:
    """Move the overlapping parts of a flat map apart, without a cut.

    This is the simplicial complex augmentation framework of Jiang, Schaefer and Panozzo 2017
    (`igl.triangle.scaf_solve`). It starts from an embedding in a circle, which has no overlaps, and deforms
    the triangles towards those of `uv` without creating overlaps. It minimises the symmetric Dirichlet
    energy. Cutting along the seams of `find_separating_seams` instead is much faster and adds no distortion.

    Parameters
    ----------
    uv : (#V, 2) float
        The map; NaN is allowed at vertices that no face uses.
    F : (#F, 3) int
        Oriented triangles of one disk.
    iterations : int
        More iterations give a map closer to `uv`.
    timeout : float
        Seconds after which the solver is stopped with an error. It runs in a separate process, because igl's
        solver hangs on some maps. The limit does not affect the map of a solver that finishes in time.

    Returns
    -------
    uv : (#V, 2) float64
        The new map, rotated and moved to fit `uv` best, or a copy of `uv` if it has no overlaps and no
        flipped faces. NaN at vertices that no face uses.

    Raises
    ------
    MeshError
        The arrays do not fit together, the surface is not one disk, a face is collapsed or much smaller than
        the rest of the map, no valid embedding was found in double precision, or igl's solver failed or took
        too long.

    Warns
    -----
    OutcomeWarning
        The new map still has overlaps or flipped faces.

    Examples
    --------
    A strip, wound up by one turn and a fifth:

    >>> import numpy as np
    >>> from igl_linabf.measures.overlapping import overlaps
    >>> t = np.repeat(np.linspace(0, 7.5, 31), 2)
    >>> uv = (1 - np.tile([0, 0.2], 31))[:, None] * np.column_stack((np.cos(t), np.sin(t)))
    >>> F = [f for i in range(0, 60, 2) for f in ([i, i + 2, i + 1], [i + 1, i + 2, i + 3])]
    >>> F = np.array(F)[:, ::-1]
    >>> len(overlaps(uv, F)), len(overlaps(make_bijective(uv, F), F))
    (27, 0)
    """
    if not is_number(iterations, 1, whole=True):
        raise ValueError(f"iterations is {iterations!r}: use a positive integer")
    surface = Submesh.from_input(uv, F, 2, "uv")
    topology = surface.topology
    check_planar(topology, surface.vertices)
    if len(topology.loops) > 1:
        raise MeshError(
            f"the surface has {format_count(len(topology.loops) - 1, 'hole')}: fill them first, or cut "
            "along separating_seams"
        )
    made, trouble = separate_parts(surface.V, topology, iterations, timeout)
    if trouble:
        warnings.warn(trouble, OutcomeWarning, stacklevel=stack_level())
    return surface.scatter_to_input(made)


def separate_parts(
    flat: FloatArray, topology: Topology, iterations: int, timeout: float
) -> tuple[FloatArray, str]:
    """Run `make_bijective` on a checked map of a disk; also return a description of defects, or ""."""
    area = signed_double_areas(complex_positions(flat), topology.corner)
    total = float(np.abs(area).sum()) / 2
    bad = np.flatnonzero(~(np.abs(area) > MIN_SCAF_AREA * total))
    if len(bad):
        raise MeshError(
            f"faces {first_few(bad)} have less than {MIN_SCAF_AREA:g} of the map's area: its scale "
            "varies too much for SCAF; cut the surface into more parts"
        )
    if (area > 0).all() and not len(find_overlapping_pairs_of_chart(topology, flat)):
        return flat.copy(), ""
    made = _run_scaf(flat / np.sqrt(total), topology, iterations, timeout) * np.sqrt(total)
    flips = np.count_nonzero(~(signed_double_areas(complex_positions(made), topology.corner) > 0))
    pairs = find_overlapping_pairs_of_chart(topology, made)
    trouble = (
        f"{format_count(int(flips), 'flipped face')} and {format_count(len(pairs), 'pair')} of "
        "overlapping faces "
        f"remain after {format_count(iterations, 'iteration')}: "
        "cut the surface along separating_seams instead"
        if flips or len(pairs)
        else ""
    )
    return _fit_rigidly(made, flat), trouble


def _run_scaf(rest: FloatArray, topology: Topology, iterations: int, timeout: float) -> FloatArray:
    """Run SCAF from an embedding in a circle towards the target map `rest`, whose area must be 1.

    With an area of 1/2, `igl.triangle.scaf_solve` hangs.
    """
    for z in embed_in_circle(topology, Solvers()):
        area = signed_double_areas(z, topology.corner)
        if (area > 0).all():
            break
    else:
        raise MeshError(
            "no valid embedding in a circle was found in double precision, and SCAF has to start from one: "
            "cut the surface into more parts"
        )
    start = real_coordinates(z) / np.sqrt(area.sum() / 2)
    arrays = {"rest": rest, "F": topology.corner.T, "start": start, "iterations": np.array(iterations)}
    try:
        return np.asarray(
            run_in_child_process("igl_linabf.charts.splitting.scaf", SCAF, arrays, timeout)["uv"]
        )
    except RuntimeError as error:
        raise MeshError(f"{error}: cut the surface along separating_seams instead") from None


def _solve_scaf(arrays: Arrays) -> Arrays:
    data, rest = igl.triangle.SCAFData(), arrays["rest"]
    igl.triangle.scaf_precompute(
        np.asfortranarray(np.column_stack((rest, np.zeros(len(rest))))),
        np.asfortranarray(arrays["F"], dtype=np.int32),
        np.asfortranarray(arrays["start"]),
        igl.MappingEnergyType.SYMMETRIC_DIRICHLET,
        np.zeros(0, dtype=np.int32),
        np.zeros((0, 2), order="F"),
        0.0,
        data,
    )
    # in the result, the vertices of the scaffold follow the vertices of the mesh
    return {"uv": igl.triangle.scaf_solve(int(arrays["iterations"]), data)[: len(rest), :2]}


def _fit_rigidly(uv: FloatArray, onto: FloatArray) -> FloatArray:
    """Rotate and translate `uv` to fit `onto` best."""
    z, w = complex_positions(uv), complex_positions(onto)
    middle = w.mean()
    z = z - z.mean()
    turn = np.vdot(z, w - middle)
    z = z * (turn / np.abs(turn) if turn else 1.0) + middle
    return real_coordinates(z)


def move_parts_apart(
    piece: Submesh, result: Flattening, before: MapDistortion
) -> tuple[Flattening, float] | None:
    """Move overlapping parts of a map apart; return the new map and the increased distortion, or None.

    The result is None if SCAF fails or distorts the map too much, for example if the map is a long strip. A
    seam is better then. `before` measures the given map. The number of iterations is fixed. Therefore the
    result does not depend on the speed of the machine.
    """
    hangs = SCAF_SECONDS + SCAF_SECONDS_PER_FACE * len(piece.F)
    try:  # remaining overlaps and flips are reported by the atlas
        uv, _ = separate_parts(result.uv, piece.topology, SCAF_ITERATIONS, hangs)
    except MeshError as error:
        _warn_of_cut(piece, str(error))
        return None
    corner = piece.topology.corner
    areas = [np.abs(signed_double_areas(complex_positions(m), corner)).sum() for m in (result.uv, uv)]
    uv *= np.sqrt(areas[0] / areas[1])
    after = MapDistortion(piece, uv)
    if not after.stretch <= MAX_SCAF_STRETCH_FACTOR * before.stretch:
        _warn_of_cut(
            piece, f"SCAF would stretch the chart by {after.stretch:.3g} (L2), not by {before.stretch:.3g}"
        )
        return None
    sheared = [
        change.triangle_changes.area_weighted_mean(change.triangle_changes.conformal)
        for change in (before, after)
    ]
    if not sheared[1] <= MAX_SCAF_STRETCH_FACTOR * sheared[0]:
        _warn_of_cut(
            piece, f"SCAF would shear the chart by {sheared[1]:.3g} (conformal), not by {sheared[0]:.3g}"
        )
        return None
    shear = [float(change.triangle_changes.angle_distortion.mean()) for change in (before, after)]
    message = "no triangle overlaps another; overlaps repaired: F/3nt {:.4g} -> {:.4g}".format(*shear)
    flipped = find_flipped_faces(complex_positions(uv), corner)
    outcome = Outcome.VALID if result.outcome is Outcome.OVERLAPPING else result.outcome
    outcome = Outcome.FLIPPED if len(flipped) else outcome
    apart = replace(result, uv=uv, flipped=flipped, outcome=outcome, message=message)
    return apart, shear[1] - shear[0]


def _warn_of_cut(piece: Submesh, why: str) -> None:
    """Warn that the overlapping parts of a chart are cut apart, because SCAF cannot move them apart."""
    warnings.warn(
        f"parts of the chart of faces {first_few(piece.faces)} overlap, and are cut apart, not moved: {why}",
        FallbackWarning,
        stacklevel=stack_level(),
    )


if __name__ == "__main__":
    run_as_child_process({SCAF: _solve_scaf})
