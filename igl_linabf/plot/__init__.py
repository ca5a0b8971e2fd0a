"""Draw a surface and its flat map, atlas or grid, in pictures and an interactive window, with pyvista.

`pictures` has the functions that draw, `window` the interactive viewer, and `scene` the textures, colour
scales, cameras and lines of both.
"""

try:
    import pyvista
except ImportError as error:
    raise ImportError("pictures and windows need pyvista: pip install 'igl-linabf[viz]'") from error

from .displays import has_display
from .map_cache import Shown
from .pictures import plot_checkerboard, plot_compare, plot_distortion, plot_grid, plot_uv
from .scene import DARK, LIGHT, SEAM, WARNING, checker_texture, colour_scale, fit
from .window import MARK, Viewer, view

__all__ = [
    "DARK",
    "LIGHT",
    "MARK",
    "SEAM",
    "WARNING",
    "Shown",
    "Viewer",
    "checker_texture",
    "colour_scale",
    "fit",
    "has_display",
    "plot_checkerboard",
    "plot_compare",
    "plot_distortion",
    "plot_grid",
    "plot_uv",
    "view",
]
