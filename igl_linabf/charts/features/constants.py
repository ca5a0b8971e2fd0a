"""The constants of features."""

import numpy as np

# ---- Creases and curvature

# Share of a body's extent by which coordinates in single precision are off: no choice, that is the format.
SINGLE_PRECISION = float(np.finfo(np.float32).eps)

# Height of a face, in units of `SINGLE_PRECISION` times the extent, below which it takes its neighbour's
# normal. Less lets rounding bend planes; more hides small faces. tests/charts/panels/test_panels.py: fine
# boxes in single precision.
SLIVER_NOISE = 100.0

# Radians that a normal may turn along a way as long as the body, for faces that lie flat. Less loses planes
# that are rounded; more takes smooth bodies for flat. benchmarks/constants.py charts.features
FLAT_TURN = 0.1

# Radians by which the outline of a facet turns at a corner at least. Less takes rounding for corners; more
# misses the corners of thin triangles. tests/charts/panels/test_panels.py: facets of a subdivided body.
CORNER_TURN = 0.01

# Dihedral angle from which on an edge begins to be a crease: a seam there becomes cheaper. Less sees
# creases on coarse round bodies; more misses chamfers. benchmarks/constants.py charts.features
SOFT_CREASE = np.deg2rad(15.0)

# Dihedral angle from which on a crease is sharp: shading shows it anyway. Less cuts round bodies along
# edges; more sends seams across planes. benchmarks/constants.py charts.features
SHARP_CREASE = np.deg2rad(40.0)

# Radians of curvature at a vertex off sharp creases, above which it is an apex. Less takes round bodies for
# spiky ones; more presses cones flat. tests/charts/panels/test_panels.py: what has a net is laid flat.
APEX_CURVATURE = 0.2

# Curvature of an apex on soft creases, at least, over that of its neighbours. Less finds apexes all over
# coarse balls; more misses those of coarse cones. tests/charts/panels/test_panels.py: what has a net is
# laid flat.
APEX_PROMINENCE = 4.0

# Twice the area of a face over its squared sides, up to which its body is not cut into panels. Less leaves
# a panel without a map; more keeps bodies whole. benchmarks/constants.py charts.features: for hard input,
# half and twice of it change nothing.
NEEDLE = 1e-12

# ---- Valleys, and what is hidden

# Most times that values are averaged over neighbours. Less reaches less far on fine meshes; more takes
# longer. benchmarks/unwrap_time.py prints the time.
MOST_SMOOTHING_STEPS = 30

# Distance over which curvature is smoothed to find valleys, over the square root of the area. Less follows
# noise; more misses narrow valleys. tests/charts/features/test_visibility.py: valleys attract seams.
VALLEY_SCALE = 0.02

# Twice the mean curvature, times the square root of the area, that is half a deep valley. Less makes all
# dents valleys; more none. tests/charts/features/test_visibility.py: valleys attract seams.
VALLEY_CURVATURE = 10.0

# Share of its length that a seam saves in a deep valley, or on a crease of a right angle. Less lets seams
# cross open surface; more makes them long. tests/charts/features/test_visibility.py: valleys attract seams.
FEATURE_DISCOUNT = 0.5

# Factor of a seam's length in full view; in hiding, its length is divided by it. Less leaves seams in view;
# more makes them long. tests/charts/features/test_visibility.py: seams move to the side that is not seen.
HIDING = 3.0

# How well the back of a body hides a seam, if details tell where it is: by a factor of 2, for it is a
# guess. Less leaves seams in a face; more lengthens them. tests/charts/features/test_visibility.py: seams
# stay off a face.
BACK_HIDING = float(np.log(2.0) / np.log(HIDING))

# ---- The front of a body

# Distance over which curvature is smoothed to tell details from shape, over the square root of the area.
# Less sees noise only; more sees limbs. tests/charts/features/test_visibility.py: seams stay off a face.
DETAIL_SCALE = 0.05

# Triangles of a body that has details, at least. Fewer give fronts to coarse handles and lids; more miss
# small heads. Half of it changes find_seams of the teapot with hide="back".
FEWEST_DETAILED = 300

# Share of the area that lies flat, above which a body is a machine part without a front. Less misses coarse
# heads; more finds faces of machines. Twice as much changes find_seams of the teapot with hide="back".
FLATTEST_DETAILED = 0.5

# Length of the mean normal, weighted by salience, from which on the front is clear; none is a tenth of
# that. Less guesses on balls; more misses faces. tests/charts/features/test_visibility.py: a body without a
# face.
CLEAR_VIEW = 0.1
