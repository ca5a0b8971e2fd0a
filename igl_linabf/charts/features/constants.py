"""Constants that several modules of `features` share."""

import numpy as np

# Rounding error of single-precision coordinates, relative to the extent of the component.
COORDINATE_NOISE = float(np.finfo(np.float32).eps)
MAX_BEND_ROUNDING = 0.05  # maximum dihedral angle, radians, that can be due to rounding at a thin face
PLANAR_SHARE = 0.35  # a component is a hard surface if at least this share of its area is flat
TIP_CURVATURE = 0.2  # minimum angle defect, radians, of a tip away from creases
