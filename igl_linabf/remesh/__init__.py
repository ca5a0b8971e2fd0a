"""Room: remesh."""

from .grid import QuadGrid, quad_grid

__all__ = [
    "QuadGrid",
    "quad_grid",
]
