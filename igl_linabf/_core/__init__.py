"""The loops over triangles, edges and matrices, compiled ahead from `src`: plain arrays in, plain arrays out.

There are two builds of the same source, for every processor and for those of x86-64-v3 (AVX2, since 2013).
"""

from . import _baseline

if _baseline.has_v3():
    from . import _v3 as _built
else:
    _built = _baseline

# overlaps
DEPTH = _built.DEPTH  # of the height of the smaller triangle, by which one may reach into another one
assembled = _built.assembled
lie_over = _built.lie_over
overlap_sheets = _built.overlap_sheets
overlapping = _built.overlapping
