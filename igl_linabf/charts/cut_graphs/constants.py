"""Constants that several modules of `cut_graphs` share."""

STRICTLY_SHORTER = 1 - 1e-9  # tolerance factor: a is strictly shorter than b if a < STRICTLY_SHORTER * b
MIN_BOND_WEIGHT = 1e-3  # minimum weight of a bond of the Laplacian, and least scaling factor between clusters
MAX_BOND_WEIGHT = 1e6  # maximum weight of a bond of the Laplacian, half a sum of cotangents
MAX_MOVED_ARCS = 24  # maximum number of arcs or branch points that are moved
