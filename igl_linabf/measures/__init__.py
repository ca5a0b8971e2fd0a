"""Quality measures of flat maps.

Given a surface and a map of it: the distortion of each triangle, totals over the map, the error of distances,
and the pairs of overlapping triangles. F/3nt is the measure of the paper (table 1). The stretch is defined by
Sander, Snyder, Gortler and Hoppe (2001).
"""

from .distances import RINGS, Distances, check_rings, distance_error
from .figures import Quality, QualityReport, format_table, measure_qualities, measure_quality, quality
from .overlapping import (
    MAX_PAIRS,
    NO_PAIRS,
    find_crossed_loops,
    find_overlapping_pairs,
    find_overlapping_pairs_of_chart,
    find_overlapping_pairs_of_charts,
    format_pair_count,
    overlaps,
)
from .per_triangle import MEASURES, Change, Measure, distortion, measure_change
