"""A chart whose overlapping parts are moved apart, not cut."""

import warnings
from dataclasses import replace

import numpy as np

from .._types import FloatArray, IntArray
from ..errors import FallbackWarning, MeshError, some, stack_level
from ..flattening import Flattening, Outcome
from ..measures import change_of
from ..surface import Submesh, complex_positions, flipped_faces, signed_double_areas
from .scaf import moved_apart

WAITED, PER_FACE = 30.0, 2e-3  # seconds after which igl's SCAF hangs: five times what it takes elsewhere


def made_bijective(piece: Submesh, result: Flattening) -> tuple[Flattening, float] | None:
    """The map with its overlapping parts moved apart, and the increase of F/3nt; None where SCAF cannot."""
    timeout = WAITED + PER_FACE * len(piece.F)
    try:
        uv, _ = moved_apart(result.uv, piece.topology, timeout=timeout)  # what is wrong is told of the atlas
    except MeshError as error:
        warnings.warn(
            f"parts of the chart of faces {some(piece.faces)} overlap, and are cut apart, not moved: {error}",
            FallbackWarning,
            stacklevel=stack_level(),
        )
        return None
    corner = piece.topology.corner
    areas = [np.abs(signed_double_areas(complex_positions(m), corner)).sum() for m in (result.uv, uv)]
    uv *= np.sqrt(areas[0] / areas[1])
    before, after = (float(change_of(piece, m).angle_distortion.mean()) for m in (result.uv, uv))
    message = f"{result.message}; moved apart to be bijective: F/3nt {before:.4g} -> {after:.4g}"
    return _with_map(result, uv, corner, message), after - before


def _with_map(result: Flattening, uv: FloatArray, corner: IntArray, message: str) -> Flattening:
    flipped = flipped_faces(complex_positions(uv), corner)
    outcome = Outcome.FLIPPED if len(flipped) else result.outcome
    return replace(result, uv=uv, flipped=flipped, outcome=outcome, message=message)
