"""Constants that several modules of `seams` share."""

TRADE = 6.0  # default of `trade`: seam length, in sqrt(area), worth a decrease of the L2 stretch by 1
MAX_BRANCHES = 100  # maximum number of branches of a component's seam, for any `trade`
MAX_IDLE_BRANCHES = 3  # stop adding branches after this many in a row that do not lower the cost
