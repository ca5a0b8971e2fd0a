"""Regions that can be laid flat without stretch, put together edge to edge.

In: a surface with creases. Out: seams around the planes, cylinders and cones between sharp or rounded
creases.
"""

from .panels import Panels, RoundedPanels, panel_seams
from .unfolding import overlap_depths
