"""The loops over triangles and edges that take most of the time, each in two forms.

In: plain arrays. Out: plain arrays. A kernel is defined by its form in NumPy. Beside it stands the same as
loops, which numba compiles where it is installed (the extra `fast`). For factors there are loops only:
without numba, a library makes them.
"""

from .._core import (
    DEPTH,
    assembled,
    lie_over,
    overlap_sheets,
    overlapping,
    above,
    arcs_between,
    behind_least_cut,
    boundary_loops,
    connected_labels,
    cycles,
    entries,
    fans_around,
    far_apart,
    in_edges,
    in_one_piece,
    meeting,
    nearest_sources,
    nodes_on_paths,
    opened,
    shortest_odd_walk,
    shortest_pairs,
    spanning_forest,
    undirected,
    used_vertices,
    way_of_fewest,
    ways_towards,
    without_leaves,
)
from .choice import fast_by, is_fast, numpy_only
from .cholesky import Factor, analysed, factored
from .development import developed
from .dissection import dissected, neighbours, separators
from .drawing import drawn
from .drawn_loops import drawn_loops
from .lines_across import divisions
from .many_sides import backward_many, forward_many
from .maps import centred, changes, signed_double_areas
from .minimum_degree import minimum_degree
from .places import placed, taken_cells
from .rectangles import narrowest_turns
from .shelves import on_shelves
from .small_disks import STEPPED, STILL, THIN, Limits, flat_disks
from .small_systems import solved, solved_inside
from .some_rows import block_rows, blocks_of_rows, left_at_rows, without_rows
from .substitution import backward_one, backward_two, forward_one, forward_two
from .supernodal import Subtrees, Work, fresh, supernodal_factor, supernodal_front
from .supernodes import Supernodes, doubled, padded, subtrees, supernodes
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
