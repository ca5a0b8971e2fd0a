"""Constants that several modules of `surface` share."""

# Range of the largest coordinate in which fourth powers of lengths neither overflow nor vanish.
LARGEST_COORDINATE = 1e60
SMALLEST_COORDINATE = 1e-60

LARGEST_SEARCHED_POLYGON = 200  # larger polygons are triangulated by ear clipping, in less than O(k^3)
