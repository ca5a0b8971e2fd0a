"""Draw sewing patterns at true scale, and write them as SVG, DXF or PDF.

A `Pattern` has the outlines of the pieces of a flattened surface in millimetres, with numbered seams, fold
lines and grain arrows.
"""

from .options import DEFAULT_UNITS as DEFAULT_UNITS
from .options import MILLIMETRES
from .options import PatternOptions as PatternOptions
from .pattern import Pattern, PatternReport
from .pattern import build_pattern as build_pattern
from .seam_pairs import PatternSeam
from .tabs import PatternTab
from .writing import PAPERS, PATTERN_SUFFIXES, write_pattern
from .writing import writing_pattern as writing_pattern

UNITS = tuple(MILLIMETRES)
