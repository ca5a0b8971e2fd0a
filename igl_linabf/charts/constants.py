"""Constants that several modules share."""

SEAMS_END = 0.3  # progress, from 0 to 1, when all seams have been found
CHARTS_END = 0.95  # progress, from 0 to 1, when all charts have been flattened
MAX_OVERLAP_ROUNDS = 20  # rounds of cuts between overlapping parts, before a chart is halved
# Maximum distance of the seam that halves a chart from its middle, relative to the chart's extent.
HALVING_BAND = 0.15
