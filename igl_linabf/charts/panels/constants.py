"""Constants that several modules share."""

MAX_DEPTH_OF_HEIGHT = 0.05  # depth over the height of a face to which it may overlap others
