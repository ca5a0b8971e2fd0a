"""Where a surface bends, and where a seam would be seen.

In: a surface. Out: dihedral angles, creases, curvature without noise; how visible each vertex is.
"""

from .creased_surface import Creased
from .curvature import (
    NOISE,
    SHARP,
    TIP,
    Smoothing,
    all_bends,
    angle_noise,
    extent,
    face_normals,
    flat_share,
    flat_shares,
    sharpness,
    sides_of_box,
    tips,
)
from .visibility import HIDING, Hiding, hiding, shown, valleys
