"""A chart whose overlapping parts are moved apart, not cut."""

import warnings
from dataclasses import replace

import numpy as np

from ..._types import FloatArray, IntArray
from ...errors import FallbackWarning, MeshError, some, stack_level
from ...flattening import Flattening, Outcome
from ...surface import Submesh, complex_positions, flipped_faces, signed_double_areas
from .reused_maps import MapMeasure
from .scaf import moved_apart

WAITED, PER_FACE = 10.0, 1e-3  # seconds after which igl's SCAF hangs: elsewhere it takes 0.4 ms a face
LOST = 1.2  # times its L2 stretch, beyond which a map has not come apart: it takes 1.1 where SCAF converges


def move_parts_apart(
    piece: Submesh, result: Flattening, before: MapMeasure
) -> tuple[Flattening, float] | None:
    """The map with its overlapping parts moved apart, and the increase of F/3nt; None where SCAF cannot.

    `before` is the map measured. On long strips SCAF stops far from it, and a seam is better.
    """
    try:  # what is wrong is told of the atlas
        uv, _ = moved_apart(result.uv, piece.topology, timeout=WAITED + PER_FACE * len(piece.F))
    except MeshError as error:
        _tell(piece, str(error))
        return None
    corner = piece.topology.corner
    areas = [np.abs(signed_double_areas(complex_positions(m), corner)).sum() for m in (result.uv, uv)]
    uv *= np.sqrt(areas[0] / areas[1])
    after = MapMeasure(piece, uv)
    if not after.stretch <= LOST * before.stretch:
        _tell(piece, f"SCAF would stretch the chart by {after.stretch:.3g} (L2), not by {before.stretch:.3g}")
        return None
    shear = [float(change.at_triangles.angle_distortion.mean()) for change in (before, after)]
    message = "{}; moved apart to be bijective: F/3nt {:.4g} -> {:.4g}".format(result.message, *shear)
    return _with_map(result, uv, corner, message), shear[1] - shear[0]


def _tell(piece: Submesh, why: str) -> None:
    """Warn that parts of a chart cannot be moved apart."""
    warnings.warn(
        f"parts of the chart of faces {some(piece.faces)} overlap, and are cut apart, not moved: {why}",
        FallbackWarning,
        stacklevel=stack_level(),
    )


def _with_map(result: Flattening, uv: FloatArray, corner: IntArray, message: str) -> Flattening:
    flipped = flipped_faces(complex_positions(uv), corner)
    outcome = Outcome.FLIPPED if len(flipped) else result.outcome
    return replace(result, uv=uv, flipped=flipped, outcome=outcome, message=message)
