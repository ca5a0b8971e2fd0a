"""Constants of atlases. `benchmarks/constants.py charts.atlas` halves and doubles each of them."""

import numpy as np

# L2 stretch of a chart above which it is beyond use: a texture is then ten times coarser than it could be.
# Below, the chart is good; above, it is cut further, or the atlas says so. tests/charts/test_unwrapping.py,
# `troubles`.
UNUSABLE_STRETCH = 10.0

# Relative rounding error of an L2 stretch. A chart that is above the stretch that was asked for by less than
# this is good; by more, it is cut further. test_the_stretch_of_each_chart_is_bounded_if_asked.
STRETCH_ROUNDING = 1e-9

# Logarithm of the ratio of the two sides of a seam, up to which they match and a texture can go on across it.
# Cones whose seams differ by more are told, or refused where there is a period.
# tests/charts/cones/test_cones.py.
SEAM_TOLERANCE = 1e-4

# Height over the longest side that a chart of one thinner triangle gets. With less, rounding may turn the
# triangle over; more would show. tests/surface/repair/test_slivers.py:
# test_a_thin_triangle_is_a_chart_of_its_own_shape.
SLIVER_HEIGHT = 1e-6

# The same over the distance from the origin, where that is more: a few roundings of its coordinates.
SLIVER_ROUNDING = 16 * np.finfo(float).eps

# Rows of charts, and of troubles, in a notebook. More fill the page; of fewer it is not seen which charts are
# bad. tests/_notebook/test_pages.py.
NOTEBOOK_CHARTS = 20
