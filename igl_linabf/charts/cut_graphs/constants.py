"""Constants that several modules of `cut_graphs` share."""

STRICTLY_SHORTER = 1 - 1e-9  # a length is shorter than another length only below this multiple of it
MIN_BOND_WEIGHT = 1e-3  # least weight of a bond of the Laplacian, and its least factor between clusters
MAX_BOND_WEIGHT = 1e6  # largest weight of a bond of the Laplacian, half a sum of cotangents
MAX_MOVED_ARCS = 24  # largest number of arcs or branch points that are moved
