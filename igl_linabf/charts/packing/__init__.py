"""Charts on pages.

In: flat charts. Out: each with its page, position and turn, at one common scale.
"""

from .common_pages import pack_together
from .constants import MOST_TRIAL_CHARTS, UDIM_ROW
from .packing import PackedChart, Wish, fill_of, pack_charts, pack_maps, pack_quickly
from .page_splits import cut_for_fill, cut_to_fit
from .spacing import Packing, given_packing, page_size
