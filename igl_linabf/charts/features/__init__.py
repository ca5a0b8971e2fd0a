"""Where a surface bends, and where a seam would be seen.

In: a surface. Out: dihedral angles, creases, curvature without noise; factors of the lengths of hidden seams.
"""

from .constants import PLANAR_SHARE, TIP_CURVATURE
from .creased_surface import CreasedSurface
from .curvature import (
    Smoothing,
    apexes,
    box_sides,
    dihedral_angles,
    extent,
    face_normals,
    flat_share,
    flat_shares,
)
from .rays import are_unseen
from .visibility import Hiding, hiding_weights
