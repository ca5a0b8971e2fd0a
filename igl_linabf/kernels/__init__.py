"""The loops over triangles and edges that take most of the time, each in two forms.

In: plain arrays. Out: plain arrays. A kernel is defined by its form in NumPy. Beside it stands the same as
loops, which numba compiles where it is installed (the extra `fast`). For the factors of
small systems there are loops only: without numba, a library makes them.
"""

from .choice import fast_by, is_fast, numpy_only
from .cholesky import Factor, analysed, factored
from .connectivity import boundary_loops, connected_labels, cycles, entries, in_one_piece, undirected
from .maps import first_moments, second_moments, signed_double_areas, third_moments
from .small_systems import separate_errors, solved
from .supernodes import Supernodes, supernodal_factor, supernodal_solve, supernodes
from .systems import (
    at_edges,
    block_product,
    conformal_weights,
    disparity,
    laplacian_entries,
    pair_weights,
    pulled,
    system_blocks,
)
from .triangles import (
    NEXT,
    PREV,
    angle_sums,
    conformal_errors,
    conformally,
    cotangents,
    cut_short,
    errors,
    log_sines,
    products,
    projected,
    row_sums,
    sum_by,
)
from .vectors import block_axpy, block_dots
