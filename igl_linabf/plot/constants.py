"""Define a constant that pictures and the window share."""

MARKER_RADIUS = 0.012  # radius of spheres at cones and marked points, relative to the diagonal of the object
