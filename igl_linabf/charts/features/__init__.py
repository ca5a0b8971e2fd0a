"""Creases and curvature of a surface, and the visibility of seams.

In: a surface. Out: dihedral angles, creases, curvature robust against noise; visibility factors of seams.
"""

from .constants import TIP_CURVATURE
from .creased_surface import CreasedSurface
from .curvature import box_sides, extent, flat_shares
from .rays import find_unseen_charts
from .visibility import Hiding, hiding_weights
