"""Constants that several modules of flattening share."""

TOL = 1e-8  # residual of the angle constraints at which linear ABF ends, in radians
ABF_TOL = 1e-4  # relative change of the angles at which converged ABF ends
BOUNDARY_TOL = 1e-6  # radians; tolerance of angle sums at the boundary
MOST_STRETCH = 100.0  # L2 stretch of a valid map above which a warning is issued
