"""Constants that several modules of cut graphs share."""

STRICTLY_SHORTER = 1 - 1e-9  # a length counts as shorter below this factor of another length
MIN_BOND_WEIGHT = 1e-3  # least weight of a bond of the Laplacian, and its least share among finite volumes
MAX_BOND_WEIGHT = 1e6  # largest weight of a bond of the Laplacian: a cotangent
MAX_MOVED_ARCS = 24  # number of arcs or branch points that are moved, longest first
