"""Constants that several modules of `panels` share."""

MAX_DEPTH_OF_HEIGHT = 0.05  # overlaps of unfolded faces are ignored up to this share of a face's height
