"""Creases and curvature of a surface, and the visibility of seams.

Takes a surface. Returns its dihedral angles, its creases, its curvature without the effects of rounding, and
factors on the lengths of visible and hidden seams.
"""

from .constants import TIP_CURVATURE
from .creased_surface import CreasedSurface
from .curvature import compute_flat_shares, measure_bounding_box, measure_extent
from .rays import find_unseen_charts
from .visibility import Hiding, compute_hiding_weights
