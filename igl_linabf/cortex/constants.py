"""Define constants that several modules of cortical flattening use."""

MAX_OMITTED_SHARE = 0.005  # a warning is issued if a larger share of a hemisphere's vertices is left out
MAX_DISTANCE_SOURCES = 500  # maximum number of vertices whose distances to other vertices are measured
