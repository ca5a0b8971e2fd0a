"""Constants that several modules of remeshing use."""

ROUNDING = 1e-9  # tolerance for distances from a line in cells, and for the sine of turning angles
