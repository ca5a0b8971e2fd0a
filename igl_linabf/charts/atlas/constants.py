"""The constants of atlases. `benchmarks/constants.py charts.atlas` halves and doubles each."""

import numpy as np

# Charts that a notebook lists, of thousands. Fewer hide those that are looked for; more bury the picture.
# tests/_notebook/test_pages.py
MAX_LISTED_CHARTS = 20

# L2 stretch from which a chart is cut further, and told as a trouble: a texture is then as many times coarser
# than it could be. Less cuts long seams into limbs; more leaves parts without texels.
# tests/charts/test_unwrapping.py
UNUSABLE_STRETCH = 10.0

# Share of a stretch by which rounding may exceed what is asked for. With less, charts that meet it are cut;
# more exceeds it by a digit that users read. tests/charts/test_unwrapping.py
STRETCH_ROUNDING = 1e-9

# `seam_mismatch` of an atlas with cones above which the sides of seams do not match. Less tells of maps
# that are as exact as their angles; with more, textures break at seams. tests/charts/cones/test_cones.py
MAX_SEAM_MISMATCH = 1e-4

# Height over the longest side that a chart of one thinner triangle is opened to. Less leaves maps that
# packing turns into lines; more shows in the map. benchmarks/constants.py charts.atlas
MIN_LONE_HEIGHT = 1e-6

# Height over the distance from the origin that such a triangle gets, at least: some roundings of its
# coordinates. With less, rounding closes it again; more shows in the map.
# benchmarks/constants.py charts.atlas
LONE_ROUNDING = 16 * np.finfo(float).eps

# Double area of a face in a given map, over its size times the largest coordinate, below which its sign is
# rounding: single precision has 6e-8. Less cuts slivers of such files out as if they turned over; more does
# not see thin faces that do. tests/charts/atlas/test_polygons.py
MIN_TURNING_AREA = 1e-6
