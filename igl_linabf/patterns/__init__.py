"""Draw sewing patterns at true scale, and write them as SVG, DXF or PDF.

A `Pattern` has the outlines of the pieces of a flattened surface in millimetres, with numbered seams, fold
lines and grain arrows.
"""

from .pieces import DEFAULT_UNITS as DEFAULT_UNITS
from .pieces import MILLIMETRES, Pattern
from .pieces import build_pattern as build_pattern
from .seam_pairs import PatternSeam
from .writing import PAPERS, PATTERN_SUFFIXES, write_pattern
from .writing import writing_pattern as writing_pattern

UNITS = tuple(MILLIMETRES)
