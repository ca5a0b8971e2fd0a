"""Constants that several modules of flattening share."""

TOL = 1e-8  # radians; linear ABF ends at this residual of the angle constraints
ABF_TOL = 1e-4  # converged ABF ends at this relative change of the angles
BOUNDARY_TOL = 1e-6  # radians; tolerance of angle sums at the boundary
MOST_STRETCH = 100.0  # a larger L2 stretch of a valid map leads to a warning
