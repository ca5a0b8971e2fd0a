"""Regions that can be laid flat without stretch, put together edge to edge.

In: a surface with creases. Out: seams around planes, cylinders and cones; around what lies between sharp
creases, and between rounded ones.
"""

from .panels import Panels, RoundedPanels, panel_seams
from .unfolding import overlap_depths
