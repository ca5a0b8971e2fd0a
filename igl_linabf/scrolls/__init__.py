"""Flatten scroll segments: grids of points on papyrus, as the Vesuvius Challenge's tools make them.

`igl_linabf.io.read_tifxyz` and `write_tifxyz` read and write the format of segments.
"""

from .flattening import flatten_segment, memory_needed
from .report import FlatSegment, SegmentReport
from .synthetic import synthetic_segment

__all__ = ["FlatSegment", "SegmentReport", "flatten_segment", "memory_needed", "synthetic_segment"]
