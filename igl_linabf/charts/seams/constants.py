"""The constants of seams. `benchmarks/constants.py charts.seams` halves and doubles each."""

# --- the price of seams ---

# Default of `trade`: seam length, in square roots of the area, that a fall of the L2 stretch by 1 is worth.
# Less leaves maps that shrink limbs; more cuts long seams for little. tests/charts/seams/test_search.py
TRADE = 6.0

# Factor on `trade` for seams of clusters, which get shorter when they are pulled tight. Less leaves out
# branches that pay on the surface; more keeps some that do not. tests/charts/cut_graphs/test_clusters.py
CLUSTER_TRADE_FACTOR = 1.6

# Cost, in L2 stretch, that seams may rise by if they run in valleys. More gives up good seams for a place
# where they show less; at 0 few of them move. tests/charts/features/test_visibility.py
VALLEY_COST = 0.01

# Cost, in L2 stretch, that the same seam on both sides of a symmetric body is worth. More prefers worse
# seams; less cuts such bodies askew. tests/charts/features/test_visibility.py
SYMMETRY_COST = 0.05

# --- leaves ---

# Leaves that a component's seam grows, whatever `trade` is. Fewer leave limbs of many-limbed bodies uncut;
# each takes a factor, so that no bound takes minutes. docs/unwrapping.md
MAX_LEAVES = 100

# Leaves in a row that do not lower the cost, before no more are tried. Fewer miss those that pay only
# together; each takes a factor. benchmarks/constants.py charts.seams
MAX_LEAVES_IN_VAIN = 3

# --- large surfaces ---

# Clusters of nodes on which seams are found, at most. More take longer; fewer hide small limbs.
# tests/charts/cut_graphs/test_clusters.py
MAX_CLUSTERS = 6_000

# Faces from which a surface is large: seams of its parts are found on clusters from fewer nodes on. Less
# makes seams of small surfaces longer for no time; more lets parts take as long as all the rest.
# benchmarks/constants.py charts.seams
MIN_FACES_OF_LARGE_SURFACE = 20_000

# Nodes of a part of a large surface up to which its seam is found on the part itself. More takes longer;
# fewer make seams a little longer. benchmarks/constants.py charts.seams
MAX_DIRECT_NODES_OF_PART = 4_000

# --- many small components ---

# Faces of a component whose seam is found together with those of others. Larger ones have seams that are
# worth a search of their own; with a smaller limit, each takes longer than all of them together.
# tests/charts/panels/test_panels.py
MAX_FACES_OF_SMALL_BODY = 100

# Components from which on this is so. Fewer save no time; a higher limit searches each alone.
# tests/charts/panels/test_panels.py
MIN_SMALL_BODIES = 8

# The same two for components that hardly have planes: faces, and components. Larger ones gain
# by a search of their own; with lower limits, hundreds of bodies take minutes.
# benchmarks/constants.py charts.seams
MAX_FACES_OF_MEDIUM_BODY = 2_000
MIN_MEDIUM_BODIES = 100

# Share of its area that lies flat, below which a component hardly has planes. More takes
# parts of planes for smooth bodies; less searches each of these alone. benchmarks/constants.py charts.seams
MAX_FLAT_SHARE_OF_SMOOTH_BODY = 0.1

# --- mirror planes ---

# Square roots of the area by which a vertex may miss its mirror image, and share of the largest moment of
# inertia by which two have to differ to have an axis each. More takes a body for symmetric that is not; less
# misses mirrors of scanned bodies. tests/charts/features/test_visibility.py
MIRROR_TOL = 1e-3

# Share of the edges whose mirror image is an edge. Less takes meshes whose two sides differ; at 1 a diagonal
# that lies the other way hides a symmetry. tests/charts/features/test_visibility.py
MIN_MIRRORED_EDGES = 0.9

# Times the shortest way to a leaf in the mirror plane that the way within the plane may be long. More takes
# detours; less leaves the plane beside one. tests/charts/features/test_visibility.py
MAX_MIRROR_DETOUR = 1.5

# Factor on the lengths of edges in the mirror plane. At 1 seams run beside the plane; less draws them there
# from afar. tests/charts/features/test_visibility.py
MIRROR_LENGTH_FACTOR = 0.7
