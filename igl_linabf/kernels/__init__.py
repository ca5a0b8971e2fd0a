"""The loops over triangles and edges that take most of the time, each in two forms.

In: plain arrays. Out: plain arrays. A kernel is defined by its form in NumPy. Beside it stands the same as
loops, which numba compiles where it is installed (the extra `fast`). For factors there are loops only:
without numba, a library makes them.
"""

from .._core import (
    NEXT,
    PREV,
    angle_sums,
    at_edges,
    bends,
    block_dots,
    block_product,
    block_rows,
    block_step,
    block_turn,
    blocks_of_rows,
    centred,
    changes,
    conformal_errors,
    conformal_weights,
    conformally,
    cotangents,
    cut_short,
    developed,
    disparity,
    errors,
    laplacian_entries,
    left_at_rows,
    lengths,
    normals,
    pair_weights,
    product_with_pairs,
    products,
    products_of_entries,
    projected,
    pulled,
    rescaled,
    row_sums,
    signed_double_areas,
    sum_by,
    system_blocks,
    without_rows,
)
from .arcs import arcs_between, opened
from .assembly import DEPTH, Hinges, assembled
from .choice import fast_by, is_fast, numpy_only
from .cholesky import Factor, analysed, factored
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
from .dissection import dissected, neighbours, separators
from .drawing import drawn
from .drawn_loops import drawn_loops
from .fans import fans_around
from .graphs import above, far_apart, shortest_pairs
from .least_cuts import behind_least_cut
from .lines_across import divisions
from .many_sides import backward_many, forward_many
from .meetings import Sources, meeting
from .minimum_degree import minimum_degree
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
from .small_systems import solved, solved_inside
from .substitution import backward_one, backward_two, forward_one, forward_two
from .supernodal import Subtrees, Work, fresh, supernodal_factor, supernodal_front
from .supernodes import Supernodes, doubled, padded, subtrees, supernodes
from .triangle_pairs import MIN_DEPTH, lie_over, overlapping, solid_triangles
