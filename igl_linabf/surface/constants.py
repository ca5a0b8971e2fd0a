"""Constants that several modules of `surface` share."""

# Range of the largest coordinate in which fourth powers of lengths neither overflow nor vanish.
LARGEST_COORDINATE = 1e60
SMALLEST_COORDINATE = 1e-60

LARGEST_SEARCHED_POLYGON = 200  # polygons with more corners are triangulated by ear clipping, not in O(k^3)
