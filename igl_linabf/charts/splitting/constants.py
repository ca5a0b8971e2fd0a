"""The constants of splitting. `benchmarks/constants.py charts.splitting` halves and doubles each."""

# --- seams between overlaps ---

# Rounds of cuts of a chart that flips or overlaps, and of its parts; what overlaps then is halved. Fewer
# halve charts that a short seam would part; more only wait for those that no seam helps.
# tests/charts/splitting/test_splitting.py
MAX_SPLITS = 20

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

# L2 stretch and conformal distortion of a map up to which it is isometric, and cut along creases alone. More
# leaves overlaps of smooth maps to creases; less lets noise hide a net. tests/charts/panels/test_panels.py
MAX_ISOMETRIC_DISTORTION = 1.005

# --- maps that parts keep ---

# Share of a chart's faces from which on a part keeps the map. Smaller parts gain by a new map; a higher share
# flattens anew what gains nothing. benchmarks/constants.py charts.splitting
MIN_PART_OF_MAP = 0.9

# L2 stretch up to which this share holds. Parts of a map of more stretch gain by a new one, with fewer
# overlaps; with a lower limit, most are flattened in vain. benchmarks/constants.py charts.splitting
REUSED_STRETCH = 1.3

# The same share for maps of more stretch. Less keeps maps that a cut would relax; at 1 each face cut off
# flattens the rest again. benchmarks/constants.py charts.splitting
MIN_PART_OF_STRETCHED_MAP = 0.995

# L2 stretch and conformal distortion up to which a part of any size keeps the map: a new one is the same.
# More keeps what could be better; with less, rounding flattens exact nets again.
# tests/charts/panels/test_panels.py
MAX_EXACT_DISTORTION = 1 + 1e-4

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

# --- overlaps and tips predicted on clusters ---

# Share of the faces of a coarse mesh that is small: of overlapping ones, below which the surface is not cut
# beforehand, and of a part, which then joins a neighbour. Less cuts slivers off large charts; more leaves
# overlaps to maps that are then made again. tests/charts/splitting/test_predicted_overlaps.py
MIN_PREDICTED_SHARE = 0.02

# Overlaps that one search separates here. More part what a new map of the parts would not overlap; fewer take
# more rounds. benchmarks/constants.py charts.splitting
MAX_PREDICTED_OVERLAPS = 3

# Disks beyond which nothing is predicted: cuts of so many parts take longer than the map of the whole. Fewer
# give up bodies of many handles. tests/charts/cut_graphs/test_clusters.py
MAX_PREDICTED_DISKS = 300

# Rounds of seams to the tips of a part. Fewer leave tips that others hid; more find few.
# tests/charts/splitting/test_predicted_overlaps.py
MAX_COARSE_TIP_ROUNDS = 3

# Edges at each hole and handle that a coarse mesh may lack. More lets seams pass where there is no mesh;
# fewer give up the prediction. tests/charts/cut_graphs/test_clusters.py
MAX_MISSING_EDGES = 4

# --- faces laid out narrower ---

# Groups of connected faces that overlap, beyond which seams part them. More take longer than seams; fewer cut
# where little would move. benchmarks/constants.py charts.splitting
MAX_OVERLAPPING_GROUPS = 16

# Rings of faces around a group that are laid out with it where it alone finds no room. Fewer leave it no
# room; more change a map that is good. tests/charts/splitting/test_splitting.py
MAX_RELAYOUT_RINGS = 3

# Factors of the width of faces, from wide to narrow, that are tried until they fit. Narrower ones are sheared
# beyond use; fewer widths shear more than is needed. tests/charts/splitting/test_splitting.py
RELAYOUT_WIDTHS = (1.0, 0.7, 0.5, 0.35, 0.25)

# Mean angle distortion (F/3nt) of faces that got narrower. More shears textures visibly; less leaves more
# charts. tests/charts/splitting/test_splitting.py
MAX_NARROWED_SHEAR = 0.25

# Factor on the L2 stretch of a chart that such faces may bring. More spoils its texels; less leaves more
# charts. tests/charts/splitting/test_splitting.py
MAX_STRETCH_FACTOR = 1.01

# Vertices up to which the system of such faces is solved as a dense one. More take cubic time; fewer pay for
# the set-up of a sparse one. benchmarks/constants.py charts.splitting
MAX_DENSE_VERTICES = 64

# --- small charts that join a neighbour ---

# Faces of a small chart. More spoils the map of the neighbour; fewer leave chips.
# tests/charts/splitting/test_splitting.py
MAX_FACES_OF_SMALL_CHART = 16

# Share of the area that a small chart, or faces laid out narrower, may have. More moves what is seen; less
# leaves chips of coarse meshes. tests/charts/splitting/test_splitting.py
MAX_AREA_OF_SMALL_CHART = 0.01

# Share of the area up to which a chart of more faces is small, too; and these faces. More takes longer than
# it saves charts; less leaves chips of fine meshes. benchmarks/constants.py charts.splitting
NEGLIGIBLE_AREA = 1e-3
MAX_FACES_OF_NEGLIGIBLE_CHART = 300

# Share of its extent by which a chart may miss the neighbour's vertices when it is laid beside it unchanged.
# More tears; with less, rounding lays it out anew. tests/charts/splitting/test_splitting.py
FIT_TOL = 1e-5

# Mean angle distortion (F/3nt) up to which a neighbour is isometric. More takes smooth maps for it; less
# takes rounding for shear. tests/charts/splitting/test_splitting.py
ISOMETRIC_SHEAR = 1e-12

# Mean angle distortion that nobody sees. More shears what joins an isometric neighbour; less leaves chips at
# it. tests/charts/splitting/test_splitting.py
INVISIBLE_SHEAR = 1e-8

# Factor on the neighbour's mean angle distortion that a small chart may have at full width. More shears it
# visibly; less leaves chips. tests/charts/splitting/test_splitting.py
MAX_SHEAR_FACTOR = 10.0

# Edges along a neighbour up to which parts of such a run are tried, too. More take quadratic time; fewer
# leave chips. tests/charts/splitting/test_splitting.py
MAX_EDGES_TO_TRY_PARTS = 16

# Tries to join a small chart where it does not fit unchanged. They take as long as flattening a thousand
# triangles; fewer leave chips. benchmarks/constants.py charts.splitting
MAX_JOINING_TRIES = 80

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
