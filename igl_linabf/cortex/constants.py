"""Define constants that several modules of cortical flattening use."""

MAX_OMITTED_SHARE = 0.005  # largest share of a hemisphere's vertices that is left out without a warning
SOURCE_COUNT = 500  # number of source vertices from which distances are measured
