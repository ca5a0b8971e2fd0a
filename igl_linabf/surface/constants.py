"""Constants that several modules of `surface` share."""

# Bounds of the largest coordinate, so that fourth powers of lengths neither overflow nor vanish.
LARGEST_COORDINATE = 1e60
SMALLEST_COORDINATE = 1e-60

LARGEST_SEARCHED_POLYGON = 200  # polygons with more corners are triangulated by ear clipping, not in O(k^3)
