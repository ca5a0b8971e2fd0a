"""Constants that several modules of flattening share."""

TOL = 1e-8  # tolerance of the angle constraints in linear ABF, in radians
ABF_TOL = 1e-4  # tolerance of the relative change of the angles in converged ABF
BOUNDARY_TOL = 1e-6  # radians; tolerance of angle sums at the boundary
MOST_STRETCH = 100.0  # warn if the L2 stretch of a valid map is larger
