"""Regions that can be laid flat without stretch, put together edge to edge.

In: a surface with creases. Out: seams around planes, cylinders and cones; around what lies between sharp
creases, and between rounded ones.
"""

from .nets import ANGULAR, HARD, HARD_LARGE, MOST_HANDLES, SHARP_SHARE, Nets
from .panels import Panels, seams_of_panels
from .rounded_creases import RoundedPanels
