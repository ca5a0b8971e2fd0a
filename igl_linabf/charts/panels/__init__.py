"""Regions that can be laid flat without stretch, put together edge to edge.

In: a surface with creases. Out: seams around planes, cylinders and cones; around what lies between sharp
creases, and between rounded ones.
"""

from .constants import (
    CREASED_CURVATURE_OF_NETS,
    FLAT_SHARE_OF_LARGE_NETS,
    MOST_HANDLES_OF_NETS,
    SHARP_CREASE_PRICE,
)
from .nets import Nets
from .panels import FlatPanels, Panels, RoundedPanels, panel_seams, unjoined
from .unfolding import overlap_depths
