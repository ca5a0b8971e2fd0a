"""Define constants that several modules of cortical flattening use."""

CRUMBS_SHARE = 0.005  # largest share of a hemisphere's vertices that is left out without a warning
SOURCES = 500  # number of source vertices from which distances are measured
