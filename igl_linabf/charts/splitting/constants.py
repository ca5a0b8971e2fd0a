"""The constants of splitting. `benchmarks/constants.py charts.splitting` halves and doubles each."""

# --- seams between overlaps ---

# Overlaps, the largest ones, that one search separates. Each doubles the graph that is searched; with fewer,
# seams that would part several at once are found one by one. tests/charts/splitting/test_splitting.py
MAX_OVERLAPS = 6

# Nodes of that graph: overlaps are left for later until it is as small. More takes memory and seconds; fewer
# find longer seams on large charts. benchmarks/constants.py charts.splitting
MAX_SEARCH_NODES = 1 << 19

# Factor on the lengths of edges within a sheet of an overlap. Less lets seams cut sheets in two; more makes
# other lengths count for nothing where a sheet has to be crossed. benchmarks/constants.py charts.splitting
BARRIER_COST = 1e3

# Length of seam that one part less is worth, as a share of the diagonal of the bounding box. More takes
# detours around a sheet; less makes more charts. tests/charts/splitting/test_splitting.py
PART_COST = 0.1

# --- seams to tips ---

# L2 stretch of a map from which on it may have tips that are worth a seam. Less looks at maps in vain; more
# misses single spikes. tests/charts/splitting/test_predicted_overlaps.py
TIP_STRETCH = 1.2

# Share of its area that a face at a tip has in the map, at most; twice that on a coarse mesh. Less misses
# tips; more takes the sides of a limb for them. tests/charts/splitting/test_predicted_overlaps.py
TIP_AREA_SHARE = 1 / 16

# L2 stretch that seams to tips save beyond their price. With less, charts are flattened again for nothing;
# more leaves tips. tests/charts/splitting/test_predicted_overlaps.py
MIN_TIP_GAIN = 0.008

# --- parts moved apart by SCAF ---

# Seconds after which igl's SCAF counts as hanging, and seconds a face beside these: far more than its
# iterations take, so that a busy machine makes no other charts.
SCAF_SECONDS = 300.0
SCAF_SECONDS_PER_FACE = 1e-2
# Iterations of SCAF.
SCAF_ITERATIONS = 50

# Factor on the L2 stretch of a map beyond which its parts did not come apart; where SCAF converges it is 1.1.
# More keeps maps that are stretched for nothing; less cuts good ones. docs/promises.md
MAX_SCAF_STRETCH_FACTOR = 1.2

# Share of the map's area that a triangle needs: SCAF's barrier overflows at a thinner one. More refuses maps
# that SCAF can take; with less it hangs. tests/surface/repair/test_slivers.py
MIN_SCAF_AREA = 1e-14
