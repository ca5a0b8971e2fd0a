"""How good a flat map is.

In: a surface and a map of it. Out: the distortion of each triangle, totals over the map, the error of
distances, and the pairs of triangles that overlap. F/3nt is the paper's measure (table 1); stretch is that
of Sander, Snyder, Gortler and Hoppe 2001.
"""

from .constants import RINGS
from .distances import Distances, check_rings, distance_error
from .figures import Quality, quality, quality_of, quality_of_each, table
from .overlapping import overlapping_pairs, overlapping_pairs_of_chart, overlapping_pairs_of_each, overlaps
from .per_triangle import MEASURES, Change, Measure, change_of, distortion
