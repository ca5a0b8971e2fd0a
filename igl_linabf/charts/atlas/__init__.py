"""Represent atlases and their charts.

Takes pieces of a surface, each flattened on its own. Returns `Atlas` and `Chart`, the seams of texture
coordinates, and the atlas of the original mesh and its polygons.
"""

from .atlas import (
    ISOMETRY_ENERGY,
    STRETCH_ROUNDING,
    UNUSABLE_STRETCH,
    Atlas,
    AtlasBounds,
    AtlasReport,
    Chart,
    list_unmet_bounds,
    mean_energy,
)
from .given_mesh import convert_to_given_mesh, make_empty_atlas, map_sides_to_cleaned
from .pieces import flatten_piece, open_slivers, restrict_flattening, restrict_uv, scale_to_surface
from .polygons import (
    convert_repairs_to_polygons,
    convert_seams_to_triangles,
    convert_to_polygons,
    mark_diagonals,
    split_polygons,
)
from .seam_edges import (
    compute_division_price,
    find_seam_prices,
    find_seams_and_mismatch,
    find_texture_seam_rows,
    texture_seams,
)
