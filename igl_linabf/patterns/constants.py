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

# The width around the pieces, and around what is printed on a page, by which pages also overlap. With less,
# printers cut lines off; with more, there are more pages. tests/patterns/test_patterns.py reads a PDF.
MARGIN = 10.0

# The width of lines. Thinner ones do not print; thicker ones blur the cut. `demos/pattern.py` draws them.
LINE_WIDTH = 0.25

# The lengths that the bar at the foot may have. With fewer, it is shorter, and the scale worse to check; more
# are hard to read off a ruler. tests/patterns/test_patterns.py measures the bar of a PDF.
BAR_LENGTHS = (1, 2, 5, 10, 20, 50, 100, 200, 500, 1000)
