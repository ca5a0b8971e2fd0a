"""Search for seams along which a surface is cut open.

Takes a component of the surface and returns the edges of its seam. Handles are cut as in Erickson, Whittlesey
2005. Branches lead to points where the scale of the conformal map of Sawhney, Crane 2017 is far from 1.
"""

from .constants import TRADE
from .search import SeamSearch, check_trade, cut, find_seams
