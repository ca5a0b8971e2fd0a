"""Constants that several modules of `seams` share."""

TRADE = 6.0  # default of `trade`: length of a seam, in sqrt(area), that must lower the L2 stretch by 1
MAX_BRANCHES = 100  # maximum number of branches of a component's seam, for any `trade`
MAX_IDLE_BRANCHES = 3  # the search ends after this number of branches in a row that do not lower the cost
