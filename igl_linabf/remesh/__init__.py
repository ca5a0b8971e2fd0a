"""Quadrangular remeshing from a flat map.

In: a surface and a map of it without flips. Out: a `QuadGrid` of polygons on the surface, bounded by the
lines u = i spacing, v = j spacing; whole cells are quadrangles. The triangles are cut along these lines, and
the parts in a cell are merged.
"""

from .grid import QuadGrid, quad_grid
