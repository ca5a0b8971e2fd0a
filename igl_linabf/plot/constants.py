"""Constants that several modules of pictures and of the window use."""

MARKER_RADIUS = 0.012  # radius of spheres at cones and marked points, over the diagonal of the drawn object
