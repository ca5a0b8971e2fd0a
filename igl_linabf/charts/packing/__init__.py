"""Charts on pages.

In: flat charts. Out: each with its page, position and turn, at one common scale.
"""

from .packing import Placed, Wish, fill_of, pack, pack_maps, packed_quickly
from .page_splits import MOST_CHARTS, cut_for_fill, cut_to_fit
from .spacing import PADDING, Spacing
from .together import pack_together
