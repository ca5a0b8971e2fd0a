"""Split or repair charts whose maps overlap, flip triangles or shrink tips.

Takes a chart with its map. Returns seams that split the chart, or a map whose overlapping parts are moved
apart by SCAF (Jiang, Schaefer, Panozzo 2017). Small charts are then merged into adjacent charts.
"""

from .bisection import bisect_piece
from .overlap_seams import find_overlap_seams, find_separating_seams, split_overlaps
from .scaf import make_bijective, move_parts_apart
from .small_charts import merge_small_charts
from .tips import TIP_STRETCH, MapDistortion, find_seams_to_tips
