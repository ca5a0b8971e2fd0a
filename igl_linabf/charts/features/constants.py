"""Constants that several modules share."""

import numpy as np

# Rounding of a coordinate over the extent of its body, in single precision.
COORDINATE_NOISE = float(np.finfo(np.float32).eps)
MAX_BEND_ROUNDING = 0.05  # dihedral angle up to which the bend of a low face may be rounding
PLANAR_SHARE = 0.35  # share of the area that lies flat from which a body has planes
TIP_CURVATURE = 0.2  # curvature, radians, from which a vertex off all creases is a tip
