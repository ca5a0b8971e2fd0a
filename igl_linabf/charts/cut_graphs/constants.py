"""The constants of cut graphs. Lengths are those of edges as a seam counts them."""

# ---- Graphs and Laplacians

# Factor of a length below which another one is shorter. Nearer to 1, rounding decides between equal paths;
# less keeps longer ones. tests/charts/cut_graphs/test_clusters.py: seams are found wherever a surface is.
SHORTER = 1 - 1e-9

# Least weight of the Laplacian at an edge, and least share of it between clusters. Lower ones break the
# maximum principle; higher ones change scales on thin triangles. tests/charts/cut_graphs/test_clusters.py
SMALLEST_WEIGHT = 1e-3

# Largest weight of the Laplacian at an edge. Beside larger ones double precision loses the others; lower
# ones change scales on spikes. tests/charts/seams/test_search.py: seams do not depend on how thin a spike
# is.
LARGEST_WEIGHT = 1e6

# Logarithm of the scale, at most. Beyond it the squares in the stretch may overflow; far below, strong
# shrinking counts too little. tests/charts/seams/test_search.py: thin spikes.
MAX_LOG_SCALE = 100.0

# ---- Stretch of isometric maps

# Factor of the stretch of isometric maps beyond 1, which is about a sixth of conformal ones'. Less gives
# short seams and uneven texels; more long ones. tests/charts/cut_graphs/test_stretch.py: even seams are
# worth more.
ISOMETRIC_WEIGHT = 6.0

# Steps of conjugate gradients for the trace of the strain: the stretch is then right to a few percent.
# Fewer overestimate it; more take longer. tests/charts/cut_graphs/test_stretch.py compares it with maps.
TRACE_STEPS = 6

# ---- Clusters

# Nodes up to which a seam is found on the surface itself. Fewer cost 3 % of the seams' price; more take
# longer. tests/charts/cut_graphs/test_clusters.py compares both, benchmarks/unwrap_time.py prints the
# times.
DIRECT = 8_500

# Clusters on which a seam is found, at most. Fewer make it miss tips; more take longer.
# benchmarks/unwrap_time.py prints the times, benchmarks/unwrap.py stretch and length.
CLUSTERED = 6_000

# Edges between the roots of clusters, which are farther apart. Fewer make small clusters, that contract
# little; more lose the shape between them. benchmarks/constants.py charts.cut_graphs
ROOT_DISTANCE = 3

# Radians of curvature, above which a node becomes a root before those that are flat. Less lets rounding
# choose roots; more lets clusters swallow tips. benchmarks/constants.py charts.cut_graphs
FLAT_NODE = 0.1

# Width of the strip on each side in which a seam is pulled tight, in mean distances of nodes to roots. Less
# keeps the bends of clusters; more takes longer. tests/charts/cut_graphs/test_clusters.py
CORRIDOR = 3.0

# ---- Loops around handles

# Base points that are tried for the loops around handles, far from each other. Fewer find longer loops;
# more take longer. tests/charts/cut_graphs/test_clusters.py: surfaces with handles.
FIRST_BASES = 4

# Base points of a later round, along the loops found before. Fewer find longer loops; more take longer.
# benchmarks/constants.py charts.cut_graphs
BASES_OF_ROUND = 6

# Rounds of base points. Fewer find longer loops; more take longer. benchmarks/constants.py
# charts.cut_graphs
BASE_ROUNDS = 3

# ---- Shorter seams

# Branch points or arcs that may move, the longest; half as many groups of them are tried. Fewer leave seams
# of many handles longer; more take longer with each handle. benchmarks/constants.py charts.cut_graphs
MOST_MOVED = 24

# Arcs at a node, the nearest to each, with which it may share its way: all where six arcs meet. Fewer leave
# loops around handles long; more take longer. benchmarks/constants.py charts.cut_graphs
NEIGHBOURS_OF_ARC = 5

# Distance of the points between which an arc slides into valleys, over the square root of the area. Less
# keeps seams where they are; more takes them away from tips. tests/charts/features/test_visibility.py:
# valleys.
VALLEY_STRIDE = 0.3

# Share of its faces that each part keeps, at least, when a seam moves. Less lets arcs around a part meet;
# more keeps seams bent. benchmarks/constants.py charts.cut_graphs
KEPT_FACES = 0.7
