"""The constants of panels. `benchmarks/constants.py charts.panels` halves and doubles each."""

import numpy as np

# Costs are in units of L2 stretch: a seam as long as `trade` times the square root of the area costs 1.

# --- what seams cost ---

# Cost of a seam on a sharp crease over that of one elsewhere. Less cuts boxes to pieces; with more, bodies
# with many creases are cut as smooth ones. tests/charts/panels/test_panels.py
SHARP_CREASE_PRICE = 0.15

# Cost of a seam on creases alone up to which nothing else is sought. With less, boxes wait for a search; with
# more, rough bodies are cut along all of their creases. tests/charts/panels/test_panels.py
MAX_CREASED_COST = 0.25

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
UNFILLED_SHARE = 0.02

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

# Share of the area from which a plane makes a panel. Less makes panels of facets; more gives small planes to
# fillets. benchmarks/constants.py charts.panels
MIN_PLANE_SHARE = 1e-3

# Area of such a plane over any beside it that is across no sharp crease. With less, strips of cylinders are
# planes; more misses some beside others. benchmarks/constants.py charts.panels
PLANE_OVER_NEIGHBOURS = 2.0

# Radians that a way of the body's extent counts where fillets are halved between planes. With less, equal
# bends decide by rounding; with more, distance counts. benchmarks/constants.py charts.panels
TURN_OF_EXTENT = 1e-3

# Radians from a plane to the faces that go with it, at most. Less leaves parts of fillets for themselves;
# more takes cylinders with planes. benchmarks/constants.py charts.panels
MAX_FILLET_TURN = np.deg2rad(60.0)

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

# Cost of its seams from which a body with rounded creases is cut in another way. Less leaves parts to a
# search that distorts them; more cuts around every plane. tests/charts/panels/test_panels.py
MAX_ROUNDED_COST = 2.0
