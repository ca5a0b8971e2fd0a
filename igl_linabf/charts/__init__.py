"""Cut any surface into charts, flatten the charts, and pack them into an atlas.

Takes V, F of any manifold. Returns seams, the surface cut along seams, or an `Atlas` of flat, packed charts.
Handles are cut as in Erickson, Whittlesey 2005. Branches of seams lead to points where the scale of the
conformal map of Sawhney, Crane 2017 is far from 1. SCAF is Jiang, Schaefer, Panozzo 2017.
"""

from .atlas import Atlas, AtlasBounds, AtlasReport, Chart, texture_seams
from .cones import Cones, find_cones
from .cost import AtlasCost
from .features import find_unseen_charts as find_unseen_charts
from .options import ChartOptions, resolve_method_of_charts, resolve_options
from .packing import FIRST_UDIM_TILE, UDIM_ROW, Packing, pack_together
from .packing import PackedChart as PackedChart
from .packing import pack_charts as pack_charts
from .packing import parse_page_size as parse_page_size
from .packing import resolve_packing as resolve_packing
from .panels import compute_overlap_depths as compute_overlap_depths
from .seams import cut, find_seams
from .splitting import find_separating_seams, make_bijective
from .unwrapping import unwrap
