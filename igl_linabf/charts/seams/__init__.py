"""Search for seams along which a surface is cut open.

In: a component. Out: the edges of its seam. Handles are cut as in Erickson, Whittlesey 2005; branches follow
the conformal scale of Sawhney, Crane 2017.
"""

from .constants import TRADE
from .search import SeamSearch, check_trade, cut, find_seams
