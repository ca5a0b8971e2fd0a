"""Constants that several modules of `charts` share."""

SEAMS_END = 0.3  # value of the progress bar, from 0 to 1, when all seams have been found
CHARTS_END = 0.95  # value of the progress bar, from 0 to 1, when all charts have been flattened
MAX_OVERLAP_ROUNDS = 20  # maximum number of cuts between overlapping parts, before a chart is halved
# A seam that halves a chart is at most this far from the middle, relative to the chart's extent.
HALVING_BAND = 0.15
