"""Room: layouts."""

from .convex import on_circle
from .coordinates import (
    GAP,
    Layout,
    LayoutName,
    check_method,
    develop_boundary,
    far_apart,
    lay_out,
    layout,
    least_squares,
    placed,
)
from .slim import injective

__all__ = [
    "GAP",
    "Layout",
    "LayoutName",
    "check_method",
    "develop_boundary",
    "far_apart",
    "injective",
    "lay_out",
    "layout",
    "least_squares",
    "on_circle",
    "placed",
]
