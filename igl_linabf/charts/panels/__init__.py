"""Find panels, the regions between creases that can be flattened without stretch, and join them edge to edge.

Takes a surface with creases. Returns seams around the planes, cylinders and cones between sharp or rounded
creases.
"""

from .panels import Panels, RoundedPanels, find_panel_seams
from .unfolding import compute_overlap_depths
