"""The loops over triangles, edges and matrices, compiled ahead from `src`: plain arrays in, plain arrays out.

There are two builds of the same source, for every processor and for those of x86-64-v3 (AVX2, since 2013).
"""

from . import _baseline

if _baseline.has_v3():
    from . import _v3 as _built
else:
    _built = _baseline

# angles: triangles, the reduced system, flat maps, conjugate gradients
NEXT = [1, 2, 0]  # corner k + 1: where the left angle beta of corner k's fan is
PREV = [2, 0, 1]  # corner k + 2: where the right angle gamma is
angle_sums = _built.angle_sums
at_edges = _built.at_edges
bends = _built.bends
block_dots = _built.block_dots
block_product = _built.block_product
block_rows = _built.block_rows
block_step = _built.block_step
block_turn = _built.block_turn
blocks_of_rows = _built.blocks_of_rows
centred = _built.centred
changes = _built.changes
conformal_errors = _built.conformal_errors
conformal_weights = _built.conformal_weights
conformally = _built.conformally
cotangents = _built.cotangents
cut_short = _built.cut_short
developed = _built.developed
disparity = _built.disparity
errors = _built.errors
laplacian_entries = _built.laplacian_entries
left_at_rows = _built.left_at_rows
lengths = _built.lengths
normals = _built.normals
pair_weights = _built.pair_weights
product_with_pairs = _built.product_with_pairs
products = _built.products
products_of_entries = _built.products_of_entries
projected = _built.projected
pulled = _built.pulled
rescaled = _built.rescaled
row_sums = _built.row_sums
signed_double_areas = _built.signed_double_areas
sum_by = _built.sum_by
system_blocks = _built.system_blocks
without_rows = _built.without_rows
