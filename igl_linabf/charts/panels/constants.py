"""Constants that several modules of `panels` share."""

MAX_DEPTH_OF_HEIGHT = 0.05  # maximum depth of an overlap between faces, relative to the height of a face
