"""Constants that several modules of flat cortices use."""

CRUMBS_SHARE = 0.005  # largest share of a hemisphere's vertices that can be left out without a warning
SOURCES = 500  # number of vertices from which distances are measured
