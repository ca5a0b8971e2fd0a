"""Constants that several modules of `packing` share."""

MIN_SHAPED_AREA = 1 / 1600  # charts with a smaller share of the total area are packed as rectangles
COARSE_TURNS = 8  # number of rotations of each chart that are tried on coarse grids
EXPECTED_FILL = 0.62  # expected covered share of a page, which sets the scale of the first grid
GROWING_ROOM = 1.3  # factor on the expected side of the search grid, and on its side after each failed trial
