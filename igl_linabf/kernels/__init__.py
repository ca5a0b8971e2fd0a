"""The loops over triangles and edges that take most of the time, each in two forms.

In: plain arrays. Out: plain arrays. A kernel is defined by its form in NumPy. Beside it stands the same as
loops, which numba compiles where it is installed (the extra `fast`). For factors there are loops only:
without numba, a library makes them.
"""

from .arcs import arcs_between, opened
from .assembly import DEPTH, Hinges, assembled
from .choice import fast_by, is_fast, numpy_only
from .connectivity import (
    boundary_loops,
    connected_labels,
    cycles,
    entries,
    in_edges,
    in_one_piece,
    spanning_forest,
    spanning_tree,
    undirected,
    used_vertices,
)
from .development import developed
from .drawing import drawn
from .drawn_loops import drawn_loops
from .fans import fans_around
from .graphs import above, far_apart, shortest_pairs
from .least_cuts import behind_least_cut
from .lines_across import divisions
from .maps import centred, changes, signed_double_areas
from .meetings import Sources, meeting
from .paths import (
    Rest,
    nearest_sources,
    nodes_on_paths,
    shortest_odd_walk,
    way_of_fewest,
    ways_towards,
    without_leaves,
)
from .places import placed, taken_cells
from .rectangles import narrowest_turns
from .sheets import overlap_sheets
from .shelves import on_shelves
from .small_disks import STEPPED, STILL, THIN, Limits, flat_disks
from .some_rows import block_rows, blocks_of_rows, left_at_rows, without_rows
from .symmetric_products import block_product, product_with_pairs, products_of_entries
from .systems import (
    at_edges,
    conformal_weights,
    disparity,
    laplacian_entries,
    pair_weights,
    product_inside,
    pulled,
    system_blocks,
)
from .triangle_pairs import MIN_DEPTH, lie_over, overlapping, solid_triangles
from .triangles import (
    NEXT,
    PREV,
    angle_sums,
    bends,
    conformal_errors,
    conformally,
    cotangents,
    cut_short,
    errors,
    lengths,
    log_sines,
    normals,
    products,
    projected,
    rescaled,
    row_sums,
    squared_cosecants,
    sum_by,
)
from .vectors import block_axpy, block_dots, dot, go, move, turn
