"""Constants of pictures and of the window; their tests are in tests/plot."""

# Radius of the spheres at cones and marked points, as a share of the diagonal of what is drawn. Smaller ones
# are hard to see; larger ones hide triangles. test_pictures.py finds the spheres.
MARKER_RADIUS = 0.012

# Radius of the spheres at the ends of seams, as the same share. Smaller ones are hard to see; larger ones
# look like marked points. `demos/interactive.py` shows them.
SEAM_END_RADIUS = 0.009

# Share of the colour circle from one arc of a seam to the next, about the golden section: neighbours differ.
# With a half or a third, colours soon come again. test_pictures.py compares both sides of seams.
HUE_STEP = 0.618

# Points of the letters in captions of `plot_compare`. Smaller ones are hard to read; larger ones run beyond
# the picture of one map. test_pictures.py finds the caption.
CAPTION_SIZE = 14

# Share of the window's height that a scalar bar takes. With less, its labels touch; with more, the map is
# smaller. test_pictures.py compares maps beside their bars.
SCALAR_BAR_HEIGHT = 0.12

# Pixels below the two sides of the window, for sliders and help. With less, the help does not fit; with more,
# the sides are smaller. test_window.py: the help does not lie over the map.
PANEL_HEIGHT = 130

# Pixels between press and release of a click, at most. With less, a trembling hand marks nothing; with more,
# turning the surface a little marks a point. test_window.py: turning marks nothing.
CLICK_MOVES = 4

# The largest number of iterations of its slider. With less, users do not see that more change nothing; with
# more, one iteration is hard to hit. test_window.py drags it.
MAX_SLIDER_ITERATIONS = 8

# The largest trade of its slider. With less, seams on every limb are out of reach; with more, low trades are
# hard to hit. test_window.py drags it.
MAX_SLIDER_TRADE = 60.0

# Height of the sliders' letters, as a share of the row's. Smaller ones are hard to read; larger ones touch
# those of the next slider. `demos/interactive.py` shows them.
SLIDER_LETTERS = 0.1
