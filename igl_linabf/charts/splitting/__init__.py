"""Split or repair charts whose maps overlap, flip triangles or shrink tips.

In: a chart with its map. Out: seams that split it; charts merged into neighbours; maps moved apart.
SCAF is Jiang, Schaefer, Panozzo 2017.
"""

from .bisection import bisect
from .overlap_seams import find_overlap_seams, separating_seams, split_overlaps
from .scaf import make_bijective, move_parts_apart
from .small_charts import merge_small_charts
from .tips import TIP_STRETCH, MapMeasure, find_seams_to_tips
