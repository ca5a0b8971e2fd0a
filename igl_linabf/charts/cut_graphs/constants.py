"""Constants that several modules of `cut_graphs` share."""

STRICTLY_SHORTER = 1 - 1e-9  # tolerance factor: a is strictly shorter than b if a < STRICTLY_SHORTER * b
MIN_BOND_WEIGHT = 1e-3  # minimum Laplacian weight of a pair of nodes, and of its factor between clusters
MAX_BOND_WEIGHT = 1e6  # maximum Laplacian weight of a pair of nodes; weights are half a sum of cotangents
MAX_MOVED_ARCS = 24  # maximum number of arcs or branch points of a seam that are moved, longest first
