"""Constants that several modules of `packing` share."""

MIN_SHAPED_AREA = 1 / 1600  # minimum share of the total area of a chart that is not treated as a rectangle
COARSE_TURNS = 8  # number of rotations of each chart that are tried on coarse grids
EXPECTED_FILL = 0.62  # expected fill of a page, which sets the scale of the first grid
GROWING_ROOM = 1.3  # initial side of the search grid over its expected side; also its growth per trial
