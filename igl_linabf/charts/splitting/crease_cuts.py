"""Cuts along creases, where an isometric map overlaps itself.

Creases bound regions: planes, cylinders, cones. An isometric map lays each out in the same place, whichever
creases are cut. So they are panels, joined again where nothing lies over anything else.
"""

import numpy as np

from ..._types import FloatArray
from ...measures import change_of
from ...surface import Submesh, complex_positions, signed_double_areas
from ..features import CreasedSurface
from ..panels import FlatPanels, unjoined
from .constants import MAX_ISOMETRIC_DISTORTION


def split_at_creases(piece: Submesh, uv: FloatArray) -> list[Submesh]:
    """The parts of a piece cut at creases where its map overlaps itself; none if it is not isometric."""
    creased = CreasedSurface(piece)
    if not is_isometric(piece, uv) or not creased.sharp.any():
        return []
    seam = unjoined(FlatPanels(creased), complex_positions(uv)[piece.F], trade=0.0)
    return piece.cut_at(piece.topology.inside[seam]) if seam.any() else []


def is_isometric(piece: Submesh, uv: FloatArray) -> bool:
    """Whether L2 stretch and conformal distortion are nearly 1; ratios of areas rule out most maps."""
    double_area = piece.measured[0]
    flat = np.abs(signed_double_areas(complex_positions(uv), piece.topology.corner))
    with np.errstate(divide="ignore"):
        least = float(double_area @ (double_area / flat)) * float(flat.sum()) / float(double_area.sum()) ** 2
    if not least < MAX_ISOMETRIC_DISTORTION**2:  # 1 / s1^2 + 1 / s2^2 >= 2 / (s1 s2) of the singular values
        return False
    changed = change_of(piece, uv)
    stretch, shear = changed.mean(changed.squared_stretch) ** 0.5, changed.mean(changed.conformal)
    return bool(max(stretch, shear) < MAX_ISOMETRIC_DISTORTION)
