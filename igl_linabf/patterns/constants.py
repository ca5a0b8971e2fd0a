"""Constants of patterns. Lengths are in millimetres."""

# Half of a grain arrow's length, as a share of the piece's extent along it. Shorter arrows are hard to lay a
# ruler along; longer ones leave more pieces, and are then shortened. `demos/pattern.py` shows them.
ARROW_HALF = 0.3

# The share of its length to which an arrow is shortened until it is within its piece. Less makes arrows
# shorter than need be; more takes longer. tests/patterns/test_patterns.py draws pieces of all shapes.
ARROW_SHRINKAGE = 0.8

# The least length of the unit grain direction, projected to a piece and averaged over it. Below, the arrow is
# along the piece; with more, slanting pieces lose their grain. `demos/pattern.py` shows arrows.
LEAST_GRAIN = 0.1

# The share of a piece that has to point one way, so that this way is up, not the mean of all. With less,
# one side of many turns a lampshade off its axis; with more, the net of a box lies askew.
# tests/patterns/test_layout.py.
AGREEING = 0.3

# Radians between directions that are taken as one. With less, rounding parts the sides of a box; with more,
# the steps of a fine cone run into one. tests/patterns/test_layout.py turns both.
SAME_DIRECTION = 1e-3

# The share of the larger extent of two pieces, or of one, up to which two sides of a seam lie on each other
# in the map. With less, single precision leaves slits in a plate; with more, gaps are closed that a blade
# could follow. tests/patterns/test_layout.py rounds its plates to single precision.
FITS = 1e-5

# The share of the width of one of two pieces, along the side that they have in common, from which on they are
# joined. With less, what is smooth hangs on single edges; with more, polygons fall off their prisms.
# tests/patterns/test_layout.py joins bands, boxes and tabs.
LEAST_HINGE = 0.2

# The longest sides of a seam, along each of which two pieces are tried. With fewer, a seam that fits along a
# short side stays; with more, seams of smooth pieces take longer. tests/patterns/test_layout.py.
MOST_HINGES = 8

# The width around the pieces, and around what is printed on a page, by which pages also overlap. With less,
# printers cut lines off; with more, there are more pages. tests/patterns/test_patterns.py reads a PDF.
MARGIN = 10.0

# The width of lines. Thinner ones do not print; thicker ones blur the cut. `demos/pattern.py` draws them.
LINE_WIDTH = 0.25

# The lengths that the bar at the foot may have. With fewer, it is shorter, and the scale worse to check; more
# are hard to read off a ruler. tests/patterns/test_patterns.py measures the bar of a PDF.
BAR_LENGTHS = (1, 2, 5, 10, 20, 50, 100, 200, 500, 1000)

# The share of the square around all pieces that margins between them may take. With more, many small pieces
# do not fit; with less, pieces touch. tests/patterns/test_layout.py lays out hundreds.
MOST_MARGINS = 0.64
