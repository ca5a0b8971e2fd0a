"""Constants that several modules of `remesh` share."""

ROUNDING = 1e-9  # tolerance for distances from a line in cells, and for the sine of turning angles
