"""Constants that several modules share."""

SEAMS_END = 0.3  # share of the progress at which seams are found
CHARTS_END = 0.95  # share of the progress at which charts are flattened
MAX_OVERLAP_ROUNDS = 20  # rounds of cuts between overlapping parts; then a chart is halved
# Share of a chart's extent, on either side of its middle, in which the seam that halves it is sought.
HALVING_BAND = 0.15
