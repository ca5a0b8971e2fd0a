"""Panels: regions between creases that can be flattened without stretch, joined edge to edge.

In: a surface with creases. Out: seams around the planes, cylinders and cones between sharp or rounded
creases.
"""

from .panels import Panels, RoundedPanels, find_panel_seams
from .unfolding import compute_overlap_depths
