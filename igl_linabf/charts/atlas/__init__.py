"""Atlases and their charts.

Input: pieces of a surface, each flattened on its own. Output: `Atlas` and `Chart`, the seams of texture
coordinates, and the atlas of the mesh and the polygons that the caller passed.
"""

from .atlas import STRETCH_ROUNDING, UNUSABLE_STRETCH, Atlas, AtlasReport, Chart
from .given_mesh import atlas_of_given_mesh, empty_atlas, map_sides_to_cleaned
from .pieces import flatten_piece, open_slivers, restrict_flattening, restrict_uv, scaled_to_surface
from .polygons import (
    atlas_of_polygons,
    mark_diagonals,
    mask_of_triangles,
    repairs_of_polygons,
    split_polygons,
)
from .seam_edges import (
    price_of_division,
    rows_of_texture_seams,
    seam_prices,
    seams_and_mismatch,
    texture_seams,
)
