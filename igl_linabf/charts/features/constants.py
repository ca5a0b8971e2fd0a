"""The constants of features. `benchmarks/constants.py charts.features` halves and doubles each."""

import numpy as np

# --- rounding ---

# Rounding of a coordinate over the extent of its body: files mostly hold single precision. Less takes what
# rounding bends for creases; more hides the bends of small faces. tests/charts/panels/test_panels.py
COORDINATE_NOISE = float(np.finfo(np.float32).eps)

# Height of a face, in roundings of its coordinates, below which it takes its neighbour's normal. With less,
# rounding turns normals by more than a hundredth; more makes narrow fillets sharp creases.
# tests/charts/panels/test_panels.py
MIN_SURE_HEIGHT = 100.0

# Faces of less height in a row that take the normal of the face beside the row. With fewer, planes seem to
# bend in the row; longer rows are rare, and more passes find none. benchmarks/constants.py charts.features
MAX_UNSURE_ROW = 8

# Radians by which rounding bends an edge within a plane, however high its faces are. Less finds no planes in
# coordinates of few digits; more joins facets of fine meshes. benchmarks/constants.py charts.features
BEND_ROUNDING = 1e-5

# Radians up to which a bend may be rounding, where faces are so low that it could be more. Less parts planes
# at slivers; with more, creases vanish there. tests/charts/panels/test_panels.py
MAX_BEND_ROUNDING = 0.05

# Radians up to which faces at an edge are in one plane of a panel. With less, planes of inexact coordinates
# fall into panels; more makes planes of fine cylinders. tests/charts/panels/test_panels.py
PLANE_BEND = 1e-3

# Height of a face over its longest side up to which double precision has no map of it as a chart. Less
# leaves such charts to fail; more leaves bodies with thin faces to slower searches.
# benchmarks/constants.py charts.features
MIN_CHART_HEIGHT = 1e-12

# --- flat parts and facets ---

# Radians that the normal may turn on a way of the square root of the area, where a surface lies flat. With
# more, smooth surfaces seem to have planes; with less, planes of coarse meshes are missed.
# tests/charts/panels/test_panels.py
FLAT_TURN = 0.1

# Radians by which the outline of a facet turns at its corners, at least. Less takes points on a straight
# side for corners; with more, narrow triangles lose theirs. tests/charts/panels/test_panels.py
MIN_CORNER_TURN = 0.01

# Share of the area that lies flat from which a body has planes, as machine parts do: nets are compared, and
# it has no front. With less, smooth bodies wait for nets; with more, parts of planes and fillets get none.
# tests/charts/panels/test_panels.py
PLANAR_SHARE = 0.35

# --- creases and tips ---

# Radians of curvature from which a vertex off all creases is a tip, as a cone's apex is. Less sends nets
# through vertices of smooth parts; more presses the tips of blunt cones flat.
# tests/charts/panels/test_panels.py
TIP_CURVATURE = 0.2

# Curvature of a tip on soft creases over that of any neighbour, at least. Less makes tips of the vertices of
# coarse balls; more misses apexes of coarse cones. benchmarks/constants.py charts.features
TIP_PROMINENCE = 4.0

# Sum of the squared curvatures of a disk's vertices, in full turns, from which it may fall into panels. Less
# cuts disks that are nearly flat; with more, open boxes stay whole. tests/charts/panels/test_panels.py
MIN_DISK_CURVATURE = 0.02

# --- hidden seams ---

# Factor of the length of an edge that is seen best, and divisor where one is hidden best. Less leaves seams
# in sight; more makes long detours into hiding. tests/charts/features/test_visibility.py
HIDING = 3.0

# The same for the back of a body, which is a guess. Less leaves seams on faces; a wrong guess costs more
# with more. tests/charts/features/test_visibility.py
HIDING_ON_BACK = 2.0

# --- the front of a body ---

# Triangles of a body over those of all, from which its front is sought. Less looks at loose buttons and
# teeth; more overlooks small figures. benchmarks/constants.py charts.features
MIN_BODY_SHARE = 0.01

# Triangles from which a body has details that tell its front. Fewer hold no face; more overlooks coarse
# figures. benchmarks/constants.py charts.features
MIN_DETAILED_FACES = 300

# Scale of details over the square root of the area: salience is mean curvature at this scale less that at
# the coarse one. Less measures noise; more blurs eyes and mouth. tests/charts/features/test_visibility.py
FINE_SCALE = 0.01

# The coarse scale over the square root of the area. Less is that of the details themselves; more takes
# limbs for details. tests/charts/features/test_visibility.py
COARSE_SCALE = 0.05

# Averages over neighbours up to the coarse scale. Fewer lower both scales on fine meshes; more take longer.
# tests/charts/features/test_visibility.py
MAX_SALIENCE_STEPS = 60

# Length of the mean normal, weighted by salience, from which the front is clear. With less, vague fronts
# count fully; with more, seams lie on clear ones. tests/charts/features/test_visibility.py
CLEAR_FRONT = 0.1

# Share of that up to which there is no front. Less hides seams of balls by noise; more leaves the seams of
# figures anywhere. tests/charts/features/test_visibility.py
MIN_FRONT_SHARE = 0.1

# --- rays from outside ---

# Faces of a chart from which rays start. Fewer take charts for unseen that show in part; more take longer.
# tests/charts/features/test_rays.py
FACES_WITH_RAYS = 8

# Rays from each of them, in all directions. Fewer miss small openings; more take longer.
# tests/charts/features/test_rays.py
RAYS_OF_FACE = 100

# Where a ray starts, away from its face, over the extent of the surface. Less may hit the face itself; more
# passes through thin walls. tests/charts/features/test_rays.py
RAY_START = 1e-6
