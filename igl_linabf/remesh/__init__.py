"""Quadrangles from a flat map.

In: a surface and a map of it without flips. Out: a `QuadGrid`, polygons on the surface between the lines
u = i spacing, v = j spacing; whole cells are quadrangles. No paper: the triangles are cut along these lines,
and their parts merged by cells.
"""

from .grid import QuadGrid, quad_grid

__all__ = ["QuadGrid", "quad_grid"]
