"""The constants of splitting charts."""

# Seams between overlapping parts

# Cost of an edge inside an overlapping sheet, in lengths of it, when a seam between two sheets is sought.
# Less lets seams run through sheets; more is the same. tests/charts/splitting/test_splitting.py: a spiral.
BARRIER_COST = 1e3
# Length of a seam that one part less is worth, as a share of the bounding box's diagonal. Less cuts off more
# parts; more lets seams run around sheets. benchmarks/constants.py charts.splitting.
REGION_COST = 0.1
# Overlaps that one search for a seam separates. Fewer give longer seams; each one more doubles time and
# memory. benchmarks/constants.py charts.splitting.
MAX_OVERLAPS = 6
# Nodes of the graph that this search goes through; each overlap doubles them. Fewer separate fewer overlaps
# at once; more take seconds. tests/charts/splitting/test_splitting.py.
MAX_GRAPH_NODES = 1 << 19
# Splits of a chart and of its parts, while they flip or overlap. With fewer, charts are halved that a seam
# would mend; more take longer. tests/charts/splitting/test_splitting.py: what still overlaps is halved.
MAX_SPLITS = 20
# Mean stretch and conformal distortion up to which a map is isometric, so that it is cut along creases. Less
# cuts across planes; more joins regions that have moved. tests/charts/panels/test_panels.py.
ISOMETRIC = 1.005

# Maps that are used again

# Share of a chart's faces from which on a part keeps the chart's map. Less keeps stretch that a new map
# would not have; more flattens again. benchmarks/constants.py charts.splitting.
REUSED_SHARE = 0.9
# L2 stretch of a map, up to which it is kept by that share. Less flattens again; more keeps stretch, and
# overlaps that follow from it. benchmarks/constants.py charts.splitting.
REUSED_STRETCH = 1.3
# Share of a chart's faces from which on a part keeps a map of any stretch, as a new one is nearly the same.
# Less keeps stretch; more flattens again. benchmarks/constants.py charts.splitting.
REUSED_AT_ANY_STRETCH = 0.995
# L2 stretch and conformal distortion up to which every part keeps its map: a new one would be the same. Less
# flattens planes again; more keeps distortion. benchmarks/constants.py charts.splitting.
SAME_MAP = 1 + 1e-4

# Overlaps that are predicted, and tips

# Share of a chart's faces that are few. Fewer that flip or overlap are mended where they are, and a part of
# fewer is left to a neighbour; for more, the chart is cut. tests/charts/splitting/test_predicted_overlaps.py.
FEW_FACES = 0.02
# Predicted overlaps that one seam separates; a map made anew shows what is left of the others. Fewer take
# longer; more part overlaps that are gone by then. benchmarks/constants.py charts.splitting.
PREDICTED_AT_ONCE = 3
# Rounds of seams to the tips of a part. Fewer leave tips that show in a map only when others are cut; more
# take longer. tests/charts/splitting/test_predicted_overlaps.py: tall fins.
TIP_ROUNDS = 3
# Share of its area that a face at a tip has in the map, at most. Less leaves tips shrunk; more cuts to
# places that are no tips. tests/charts/splitting/test_predicted_overlaps.py: a spike.
SHRUNK = 1 / 16
# L2 stretch of a map, from which on it may have tips that are worth a seam. Less takes longer; more leaves
# tips shrunk. benchmarks/constants.py charts.splitting.
TIP_STRETCH = 1.2
# L2 stretch that seams to tips have to save beyond their price, as the chart is flattened again for them.
# Less flattens again for nothing; more leaves tips shrunk. benchmarks/constants.py charts.splitting.
WORTH_A_SEAM = 0.008
# Change of a log scale, at any node, by the last step of conjugate gradients. Less takes more steps; more
# misses tips. tests/charts/splitting/test_predicted_overlaps.py: a spike that clusters do not show.
STILL_SCALE = 0.06

# Small charts, and faces that are laid out anew

# Faces of a chart that is merged into a neighbour, and edges of a seam of which parts are tried. Fewer leave
# more charts; more take longer. tests/charts/splitting/test_splitting.py: small charts are joined.
LARGEST_SMALL_CHART = 16
# Share of the surface's area, below which a chart of any number of faces is merged, too. Less leaves more
# charts; more takes longer. benchmarks/constants.py charts.splitting.
NEGLIGIBLE_AREA = 1e-3
# L2 stretch of a chart with all that is merged into it, in that of the chart alone. Less leaves more charts;
# more stretches. tests/charts/splitting/test_splitting.py: small charts are joined.
MERGED_STRETCH = 1.01
# Share of its extent by which a chart may miss the edges that it is moved to. Less lays it out anew, which
# shears; more opens gaps. benchmarks/constants.py charts.splitting.
ALIGNMENT_GAP = 1e-5
# Mean angle distortion that nobody sees; a chart of less is isometric. Less leaves charts apart for
# rounding; more shears planes. benchmarks/constants.py charts.splitting.
UNSEEN_SHEAR = 1e-8
# Mean angle distortion of a chart that is merged, in that of its neighbour. Less leaves more charts; more
# shears. benchmarks/constants.py charts.splitting.
MERGED_SHEAR = 10.0
# Mean angle distortion of a chart, or of some faces, that get narrower. Less leaves more charts; more
# shears. benchmarks/constants.py charts.splitting.
NARROWED_SHEAR = 0.25
# Widths beside the seam that are tried, in those on the surface. Fewer find less room; more take longer.
# tests/charts/splitting/test_splitting.py: a few faces are laid out narrower.
WIDTHS = (1.0, 0.7, 0.5, 0.35, 0.25)
# Places and widths that are tried for one chart. Fewer leave more charts; more take longer than flattening
# it with a thousand triangles. benchmarks/constants.py charts.splitting.
MOST_MERGE_TRIES = 80
# Vertices up to which a dense matrix is solved sooner than a sparse one. Less or more takes longer; results
# differ in rounding. benchmarks/constants.py charts.splitting.
LARGEST_DENSE = 64
# Groups of connected faces that overlap, up to which they are laid out anew; of more, seams part them. Fewer
# cut more charts; more take longer and stretch. tests/charts/panels/test_panels.py: the finer rounded plate.
MOST_GROUPS = 16

# SCAF

# Seconds in which SCAF has to end, at least, and for each face: it takes 0.4 ms a face, or hangs. Less cuts
# charts that it would mend; more waits in vain. tests/charts/splitting/test_splitting.py: what takes too
# long is cut.
SCAF_SECONDS = 10.0
SCAF_SECONDS_PER_FACE = 1e-3
# L2 stretch of SCAF's map, in that of the map before, beyond which a seam is better: it takes 1.1 where SCAF
# converges, and much on long strips. tests/charts/splitting/test_splitting.py: bijective.
MOST_SCAF_STRETCH = 1.2
# Share of a map's area that a triangle has at least. A thinner one is out of range of SCAF's barrier, and an
# error says so; more refuses maps that SCAF can take. tests/measures and tests of make_bijective.
SMALLEST_SCAF_AREA = 1e-14
