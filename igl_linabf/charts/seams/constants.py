"""The constants of seams. `benchmarks/constants.py charts.seams` halves and doubles each."""

# --- the price of seams ---

# Default of `trade`: seam length, in square roots of the area, that a fall of the L2 stretch by 1 is worth.
# Less leaves maps that shrink limbs; more cuts long seams for little. tests/charts/seams/test_search.py
TRADE = 6.0

# Factor on `trade` for seams of clusters, which get shorter when they are pulled tight. Less leaves out
# branches that pay on the surface; more keeps some that do not. tests/charts/cut_graphs/test_clusters.py
CLUSTER_TRADE_FACTOR = 1.6

CHEAP_PANELS = 0.1  # cost of seams around panels up to which no others are looked for

# --- leaves ---

# Leaves that a component's seam grows, whatever `trade` is. Fewer leave limbs of many-limbed bodies uncut;
# each takes a factor, so that no bound takes minutes. docs/unwrapping.md
MAX_LEAVES = 100

# Leaves in a row that do not lower the cost, before no more are tried. Fewer miss those that pay only
# together; each takes a factor. benchmarks/constants.py charts.seams
MAX_LEAVES_IN_VAIN = 3

# --- many small components ---

# Faces of a component whose seam is found together with those of others. Larger ones have seams that are
# worth a search of their own; with a smaller limit, each takes longer than all of them together.
# tests/charts/panels/test_panels.py
MAX_FACES_OF_SMALL_BODY = 100

# Components from which on this is so. Fewer save no time; a higher limit searches each alone.
# tests/charts/panels/test_panels.py
MIN_SMALL_BODIES = 8

# The same two for components that hardly have planes, and so no nets: faces, and components. Larger ones gain
# by a search of their own; with lower limits, hundreds of bodies take minutes.
# benchmarks/constants.py charts.seams
MAX_FACES_OF_MEDIUM_BODY = 2_000
MIN_MEDIUM_BODIES = 100

# Share of its area that lies flat, below which a component hardly has planes. More lays out boxes without
# their nets; less searches for nets that smooth bodies do not have. benchmarks/constants.py charts.seams
MAX_FLAT_SHARE_OF_SMOOTH_BODY = 0.1
