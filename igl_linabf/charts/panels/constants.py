"""The constants of panels. `benchmarks/constants.py charts.panels` halves and doubles each."""

import numpy as np

# --- panels ---

# Radians of bend from which an edge parts panels. Less parts the faces of coarse cylinders; more leaves
# blunt creases bent. tests/charts/panels/test_panels.py
PANEL_ANGLE = np.deg2rad(5.0)

# Share of its area that a plane may lose when it is projected: else each of its faces lies in its own. Less
# lets rounding add up on a way through it; more distorts fine cylinders.
# benchmarks/constants.py charts.panels
MAX_PROJECTED_LOSS = 1e-4

# Gap between the two sides of a crease over the body's extent, up to which they are joined. Less cuts creases
# for rounding; more leaves maps that are stretched there. tests/charts/panels/test_panels.py
MAX_CREASE_GAP = 1e-5

# Height of a face over the body's extent up to which it overlaps nothing. With less, rounding makes overlaps
# of slivers; more misses thin ones. benchmarks/constants.py charts.panels
MIN_OVERLAPPING_HEIGHT = 1e-12

# Depth over the extent to which faces may lie over each other: single precision bends edges as much. Less
# parts exact nets; more leaves overlaps that are cut later. tests/charts/panels/test_panels.py
MAX_OVERLAP_DEPTH = 2e-6

# The same over the height of the face. With more, slivers lie over their neighbours; with less, these part
# panels. benchmarks/constants.py charts.panels
MAX_DEPTH_OF_HEIGHT = 0.05

# Difference over the extent, and in radians, up to which two motions that join panels are one crease. Less
# takes noise for two creases, each worth less; more adds up creases that do not meet.
# benchmarks/constants.py charts.panels
SAME_MOTION = 1e-3

# Number of creases between two panels along which they are tried, from the dearest to the cheapest: a curved
# crease is hundreds of them. Fewer miss places; more rarely find others.
# benchmarks/constants.py charts.panels
MAX_CREASES_OF_PAIR = 8

# Share of the gaps around a joined chart that others do not fill, and that the seam has to be worth. Less
# joins panels to sprawling charts; more cuts seams for small ones. benchmarks/constants.py charts.panels
UNFILLED_SHARE = 0.0015

# Area of the page over that of the body, which a chart may be as long as. Less cuts long bodies; more fills
# pages badly. benchmarks/constants.py charts.panels
PAGE_OVER_AREA = 2.0

# The same over the squared length of its longest panel, half of which just holds it. Less cuts nets of rods;
# more leaves charts that are longer than any panel. benchmarks/constants.py charts.panels
PAGE_OVER_SQUARED_LENGTH = 0.6

# --- panels with rounded creases ---

# Share of the area in planes that make panels from which a body has rounded creases. Less cuts smooth bodies
# along faint creases; more leaves parts with large fillets to a search. tests/charts/panels/test_panels.py
PLANAR_SHARE_OF_ROUNDED = 0.3

# Gap over the extent, up to which two sides of a rounded crease are joined, and depth to which fillets may
# lie over each other. Less parts fillets; more stretches their maps. tests/charts/panels/test_panels.py
ROUNDED_PLAY = 2e-3

# The same gap over the length of the edge. Less parts fine fillets; more turns their triangles.
# benchmarks/constants.py charts.panels
ROUNDED_PLAY_OF_EDGE = 0.1

# The same depth over the height of a face of a fillet. Less parts panels at thin faces; more leaves overlaps.
# benchmarks/constants.py charts.panels
ROUNDED_DEPTH_OF_HEIGHT = 0.3

# `SAME_MOTION` of panels with rounded creases: their two sides miss each other. Less makes several of one
# crease; more adds up creases that do not meet. benchmarks/constants.py charts.panels
SAME_ROUNDED_MOTION = 1e-2
