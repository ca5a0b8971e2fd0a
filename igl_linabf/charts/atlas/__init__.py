"""An atlas and its charts.

In: pieces of a surface, each flattened alone. Out: `Atlas` and `Chart`; the seams of texture coordinates;
an atlas given back for the vertices and polygons that the caller has.
"""

from .atlas import BEYOND_USE, ROUNDING, Atlas, Chart
from .given_mesh import NO_QUALITY, given_back, sides_of_cleaned, without_charts
from .pieces import cut_out, distortion, flattened, of_own_size, on_part, with_width
from .polygons import in_polygons, mask_of_triangles, of_polygons, split_polygons, with_diagonals
from .seam_edges import rows_between_textures, texture_seams, textured_seams
