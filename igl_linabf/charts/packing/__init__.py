"""Pack charts onto pages.

Takes flat charts. Returns the page, position and rotation of each chart, and one common scale.
"""

from .common_pages import pack_together
from .packing import (
    FIRST_UDIM_TILE,
    UDIM_ROW,
    PackedChart,
    PackingRequest,
    measure_fill,
    pack_charts,
    pack_maps,
)
from .page_splits import MOST_TRIAL_CHARTS, cut_for_fill, cut_to_fit
from .spacing import Packing, parse_page_size, resolve_packing
