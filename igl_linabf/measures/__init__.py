"""Room: measures."""

from .figures import Quality, quality, table
from .overlapping import charts, overlaps
from .per_triangle import MEASURES, Measure, change_of, distortion

__all__ = [
    "MEASURES",
    "Measure",
    "Quality",
    "change_of",
    "charts",
    "distortion",
    "overlaps",
    "quality",
    "table",
]
