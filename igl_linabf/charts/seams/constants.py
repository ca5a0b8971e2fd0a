"""Constants that several modules share."""

TRADE = 6.0  # default of `trade`: seam length, in square roots of the area, that is worth an L2 stretch of 1
MAX_LEAVES = 100  # branches of a component's seam, for any `trade`
MAX_LEAVES_IN_VAIN = 3  # branches in a row that do not lower the cost, before the search ends
