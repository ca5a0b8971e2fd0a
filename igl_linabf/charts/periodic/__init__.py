"""Shift the two sides of each seam by whole periods of a texture, so that the texture continues across seams.

Takes charts whose seam sides differ by quarter turns. Returns the shifted charts, or a feasible period.
"""

from .period import shift_by_period
