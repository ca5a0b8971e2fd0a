"""The constants of nets and panels."""

import numpy as np

# Nets

# Share of the area that lies flat, and share of the curvature on sharp creases and in tips. From both on,
# nets are compared with other seams; below, creases are taken for those of a smooth body.
# tests/charts/panels: subdivided rocks, machine part.
FACETED_SHARE = 0.5
# The same share of the area, for surfaces of more than `DIRECT` vertices, where each comparison takes two
# maps. Fewer planes are not worth that time. tests/charts/splitting/test_predicted_overlaps.py: tall fins of
# a large plate.
FLAT_SHARE_OF_LARGE = 0.8
# Handles of such a surface, up to which nets are compared: a net opens each, and sheets of it then lie over
# each other. Fewer stretch creased bodies; more cut them into charts. tests/charts/cut_graphs: a plate with
# bores.
MOST_HANDLES_OF_NETS = 8
# Radians of curvature at a vertex on a crease, above which a net goes through it; a net for each. Less gives
# longer nets that are exact; more leaves stretch and is shorter. benchmarks/constants.py charts.panels:
# coarse cones need all three.
NET_CURVATURES = (0.0, 0.02, 0.2)
# Price of a seam on a sharp crease, as a share of one elsewhere, beyond a length that is free. Less lets
# boxes fall apart; more sends seams across planes. tests/charts/panels/test_panels.py: what has a net is
# laid flat without distortion.
SHARP_CREASE_PRICE = 0.15
# L2 stretch, beyond one, that a net may leave and count as exact. Less refuses nets of rounded coordinates;
# more accepts pressed vertices. tests/charts/panels/test_panels.py: nets in single precision.
EXACT_NET = 1e-3
# Price, in units of L2 stretch, below which an exact net is taken without a comparison; also how far below
# its expectation a map may come. More takes nets that are dearer than seams. benchmarks/constants.py
# charts.panels.
CHEAP_NET = 0.05
# The same price where all curvature is on sharp creases: seams past corners press these flat. Less takes
# longer, as more nets are compared; more takes dear ones. tests/charts/panels/test_panels.py: a plate is cut
# along sharp creases.
CHEAP_NET_AT_CREASES = 0.5

# Panels between sharp creases

# Bend from which on an edge parts two panels. Less takes facets of cylinders for panels; more lays soft
# creases flat, which shears. tests/charts/panels/test_panels.py: cylinders and cones of few sides.
FOLD = np.deg2rad(5.0)
# Radians by which a plane may bend at an edge, and for which a way as long as the body counts on a fillet.
# Less breaks planes of rounded coordinates; more takes bent surfaces for planes. benchmarks/constants.py
# charts.panels.
PLANE_BEND = 1e-3
# The same at edges of slivers, where rounding bends a plane by more. Less parts planes at slivers; more
# joins planes across them. tests/charts/panels/test_panels.py: likes of a surface in single precision.
SLIVER_BEND = 0.05
# Share of the body's extent by which two sides of a crease may miss each other, and faces may reach into
# each other. Less fails in single precision; more lets panels overlap. tests/charts/panels/test_panels.py:
# fine boxes are one net.
PANEL_GAP = 1e-5
# Share of its height by which a face may reach into another one. Less takes nets of slivers apart; more lets
# charts overlap. tests/charts/panels/test_panels.py: fine boxes in single precision are one net.
PANEL_REACH = 0.05
# Share of the extent, and radians, up to which two motions are one, so that edges in a row are one crease.
# Less tries each edge of it alone; more takes two creases for one. benchmarks/constants.py charts.panels:
# the cone.
SAME_MOTION = 1e-3
# Creases of two panels along which they are tried. Fewer miss the one that fits; more take longer, as a
# curved crease has hundreds. tests/charts/panels/test_panels.py: cylinders and cones.
TRIED_CREASES = 8
# Share of the empty area in a chart's rectangle that other charts leave empty. Less joins panels to long
# nets that fill pages badly; more leaves them apart. benchmarks/unwrap.py prints seams and fill.
WASTED_SHARE = 0.02
# Area of the page, in areas of the body, that a net should fit into. Less cuts long nets apart; more lets
# pages become long. benchmarks/unwrap.py prints seams and fill.
PAGE_OF_NETS = 2.0
# Half a page's squared diagonal, in squares of the longest panel: no page is smaller. Less cuts long panels
# off their neighbours; more lets pages become long. benchmarks/constants.py charts.panels: the ant.
LONGEST_PANEL = 0.6

# Panels between rounded creases

# Share of the body's area from which a plane makes a panel. Less takes facets of fillets for panels; more
# loses small planes. benchmarks/constants.py charts.panels.
PLANE_AREA = 1e-3
# How many times larger it is than any plane beside it, but for those across sharp creases. Less takes strips
# of cylinders for panels; more loses planes. tests/charts/panels/test_panels.py: bodies with fillets.
LARGER_THAN_BESIDE = 2.0
# Radians, from the plane of a panel, by which the faces of a fillet may be turned that go with it. Less
# leaves the middle of a fillet to itself; more bends panels too far. tests/charts/panels/test_panels.py:
# bodies with fillets.
LARGEST_TURN = np.deg2rad(60.0)
# Share of a body's area in such planes, from which on it is laid flat by panels. Less cuts smooth bodies
# along small planes; more stretches bodies with fillets. tests/charts/panels/test_panels.py: a machine part.
PLANAR_SHARE = 0.3
# Share of the extent by which two sides of a fillet's middle may miss each other, and faces may reach into
# each other. Less takes nets apart; more lets charts overlap. tests/charts/panels/test_panels.py: the net of
# a rounded box.
FILLET_GAP = 2e-3
# The same gap as a share of the edge's length, at most. Less takes nets of coarse fillets apart; more joins
# what does not fit. benchmarks/constants.py charts.panels.
FILLET_GAP_OF_LENGTH = 0.1
# Share of its height by which a face of a fillet, which is not flat, may reach into another one. Less takes
# nets apart at the ends of fillets; more lets charts overlap. tests/charts/panels/test_panels.py: bodies
# with fillets do not overlap.
FILLET_REACH = 0.3
# `SAME_MOTION` of panels that meet in fillets. Less tries each edge of a fillet alone; more takes two
# creases for one. benchmarks/constants.py charts.panels.
SAME_FILLET_MOTION = 1e-2
# Price of a body's seams, in units of L2 stretch, from which on it is cut as a smooth one. Less stretches
# planes; more cuts along fillets whatever `trade` says. tests/charts/panels/test_panels.py: a small trade.
DEAREST_ROUNDED = 2.0
