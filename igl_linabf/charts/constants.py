"""Constants that several modules share."""

SEAMS_END = 0.3  # fraction of the progress bar at which all seams have been found
CHARTS_END = 0.95  # fraction of the progress bar at which all charts have been flattened
MAX_OVERLAP_ROUNDS = 20  # rounds of cuts between overlapping parts, before a chart is halved
# The seam that halves a chart is within this share of the chart's extent from the middle.
HALVING_BAND = 0.15
