"""Remesh a surface into a quad-dominant grid along the iso-lines of its flat map.

The triangles are cut along these lines, and the parts in each cell are merged. Whole cells are quadrangles.
"""

from .grid import QuadGrid, quad_grid
