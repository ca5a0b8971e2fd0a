"""Patterns at true scale, to cut and join: SVG, DXF, PDF.

In: a surface and its atlas or flat map. Out: a `Pattern`, the outlines of its pieces in millimetres with
numbered seams, fold lines and grain arrows; and the drawing of it in a file.
"""

from .pieces import DEFAULT_UNITS as DEFAULT_UNITS
from .pieces import MILLIMETRES, Pattern
from .pieces import pattern_of as pattern_of
from .seam_pairs import PatternSeam
from .writing import PAPERS, PATTERN_SUFFIXES, write_pattern
from .writing import writing_pattern as writing_pattern

UNITS = tuple(MILLIMETRES)
