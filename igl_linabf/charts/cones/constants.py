"""Constants that several modules of `cones` share."""

from math import pi

CONES_PER_STRETCH = 30.0  # a decrease of the expected L2 stretch by 1 is worth this many cones
QUARTER_TURN = pi / 2  # radians
MAX_QUARTERS = 3  # maximum curvature of a cone in quarter turns: its angle sum is at least one quarter turn
