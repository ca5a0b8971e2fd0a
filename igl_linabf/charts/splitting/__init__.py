"""Charts cut further, or mended, where their maps overlap, flip or shrink.

In: a chart with its map. Out: seams that split it; small charts joined to neighbours; maps laid out anew.
SCAF is Jiang, Schaefer, Panozzo 2017.
"""

from .bisection import bisect
from .constants import MAX_SPLITS, TIP_STRETCH
from .crease_cuts import is_isometric, split_at_creases
from .local_relayout import relayout_locally
from .overlap_seams import seams_of_overlaps, separating_seams, split_overlaps
from .predicted_overlaps import coarse_mesh, predicted_seams
from .reused_maps import KnownMap, reuse_maps
from .scaf import make_bijective, move_parts_apart
from .small_charts import merge_small_charts
from .tips import MapMeasure, seams_to_tips
