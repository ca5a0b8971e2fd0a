"""Room: plot."""

from .pictures import checker_texture, plot_checkerboard, plot_compare, plot_distortion, plot_grid, plot_uv
from .scene import DARK, LIGHT, SEAM, WARNING, colour_scale, fit
from .window import MARK, Shown, Viewer, has_display, view

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
