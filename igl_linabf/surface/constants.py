"""Constants that several modules of `surface` share."""

# Bounds of the largest coordinate, so that fourth powers of lengths neither overflow nor vanish.
LARGEST_COORDINATE = 1e60
SMALLEST_COORDINATE = 1e-60

LARGEST_SEARCHED_POLYGON = 200  # largest polygon with an optimal O(k^3) triangulation; others: ear clipping
