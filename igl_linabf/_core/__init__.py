"""The loops over triangles, edges and matrices, compiled ahead from `src`: plain arrays in, plain arrays out.

There are two builds of the same source, for every processor and for those of x86-64-v3 (AVX2, since 2013).
"""

from . import _baseline

if _baseline.has_v3():
    from . import _v3 as _built
else:
    _built = _baseline

# packing
divisions = _built.divisions
drawn = _built.drawn
drawn_loops = _built.drawn_loops
narrowest_turns = _built.narrowest_turns
on_shelves = _built.on_shelves
placed = _built.placed
taken_cells = _built.taken_cells
