"""The constants of cut graphs. `benchmarks/constants.py charts.cut_graphs` halves and doubles each."""

# --- lengths of seams ---

# Factor on a length below which another one is shorter. At 1 a seam could go to and fro between lengths that
# differ by rounding; less keeps seams that are longer. tests/charts/seams/test_search.py
STRICTLY_SHORTER = 1 - 1e-9

# --- the Laplacian ---

# Least weight of a bond in units of its cotangent, and least share of it that finite volumes of clusters
# leave. With 0 or less, scales may have extrema off the seam, or the factor fails; more makes obtuse
# triangles, and bonds askew, too stiff. tests/charts/seams/test_search.py
MIN_BOND_WEIGHT = 1e-3

# Cotangent up to which needles are told apart. More leaves other triangles too few of the 16 digits; less
# makes needles softer than they are. tests/charts/seams/test_search.py
MAX_BOND_WEIGHT = 1e6

# --- expected stretch ---

# Logarithm of the scale up to which maps are told apart. Beyond 350 the square of the scale overflows; less
# makes long limbs look alike. tests/charts/seams/test_search.py
MAX_LOG_SCALE = 100.0

# What the stretch of an isometric map beyond 1 is multiplied by. Lower values leave limbs that stretch its
# texels; higher ones cut longer seams for what nobody sees. tests/charts/cut_graphs/test_stretch.py
ISOMETRIC_STRETCH_WEIGHT = 6.0

# Steps of conjugate gradients for the trace of the strain. Fewer expect too much stretch; with more, what is
# right to a few percent takes longer. tests/charts/cut_graphs/test_stretch.py
MAX_TRACE_STEPS = 6

# --- clusters ---

MAX_CLUSTERS = 6_000  # nodes on which seams are found; surfaces of more are contracted to clusters

# Nodes from which clusters are wide: their roots are farther apart by one edge. Wide clusters of fewer nodes
# leave too coarse a surface; narrow ones of more nodes are contracted once more.
# benchmarks/constants.py charts.cut_graphs
MIN_NODES_OF_WIDE_CLUSTERS = 12_000

# Edges between the roots of clusters: more than these, and one more for wide clusters. More makes clusters
# coarse and their seams worse; less leaves more nodes to each search.
# tests/charts/cut_graphs/test_clusters.py
CLUSTER_HOPS = 2

# Radians of curvature up to which nodes become roots in random order; above, those of most curvature come
# first. More loses the tips of small bumps; less lets noise choose the roots.
# benchmarks/constants.py charts.cut_graphs
MIN_PEAK_CURVATURE = 0.1

# Mean distances to a root that a seam of clusters may move to either side when it is pulled tight; a branch
# point may move along its arcs by twice as many. Less keeps detours through roots; more takes longer.
# tests/charts/cut_graphs/test_clusters.py
CORRIDOR_WIDTH = 3.0

# --- handles ---

# Points, far from each other, through which loops around handles are tried first. Fewer find longer loops;
# each takes two spanning trees. tests/charts/seams/test_search.py
FIRST_BASE_POINTS = 4

# Points of a further round, which lie in the middle of the best loops. Fewer find longer loops; more take a
# time that grows with the number of handles. tests/charts/seams/test_search.py
MAX_BASE_POINTS = 6

# Rounds of such points, the first among them. Fewer find longer loops; more hardly shorten them.
# benchmarks/constants.py charts.cut_graphs
BASE_POINT_ROUNDS = 3

# --- shorter seams ---

# Branch points, or arcs, that are moved: the longest ones. Fewer leave detours on surfaces of many handles;
# more take a time that grows with their number. tests/charts/cut_graphs/test_clusters.py
MAX_MOVED_ARCS = 24

# Groups of arcs, or of branch points, that are moved together, until each is accepted or a single one. Fewer
# give up good moves beside a bad one; each takes a comparison of the whole seam.
# benchmarks/constants.py charts.cut_graphs
MAX_MOVED_GROUPS = 12

# Share of its faces that a part keeps when seams are pulled tight. With less, arcs on both sides of it may
# meet and leave slivers; at 1 no arc between two parts could move. tests/charts/cut_graphs/test_clusters.py
MIN_KEPT_PART = 0.7
