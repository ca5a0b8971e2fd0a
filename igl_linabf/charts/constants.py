"""The constants of charts' own modules. `benchmarks/constants.py charts` halves and doubles each."""

# --- the progress that is told ---

# Share of the progress at which seams are found. Less than their share of the time lets the bar halt at
# first; more lets it halt later. tests/_runtime/test_progress.py
SEAMS_END = 0.3

# The same at which charts are flattened and packing begins. tests/_runtime/test_progress.py
CHARTS_END = 0.95

# --- which pieces are cut and flattened ---

# Number of pieces from which they are flattened and measured together. Fewer gain nothing by it; more take
# longer one by one. benchmarks/constants.py charts
MIN_PIECES_TOGETHER = 8

# Triangles, in all, of the smallest pieces, up to which these always are flattened together. More gain
# nothing by it, and miss what a single chart tries; fewer take longer. benchmarks/constants.py charts
MAX_FACES_TOGETHER = 4_000

# Twice the area of a chart over the squared extent of its map, up to which it is halved: double precision
# hardly tells the map from a line. Less leaves maps that packing flattens; more halves long strips.
# tests/charts/test_unwrapping.py
NEEDLE_AREA = 1e-13

# --- what flips ---

# Share of a chart's faces that flip, above which no tips are to blame: more seams are grown in few rounds,
# and its map is a sketch. Less halves charts early; more grows seams in vain. tests/charts/test_unwrapping.py
MAX_TIP_FLIPS = 0.05

# Rounds of more seams for flips, stretch or shrunk tips, after which a chart is halved or stays. Fewer part
# limbs and leave tips shrunk; more cut a chart to fringes. tests/charts/test_unwrapping.py
MAX_LEAF_ROUNDS = 8

# The same where more flips than tips are to blame for. Fewer halve a chart at once; more grow seams that do
# not help. tests/charts/test_unwrapping.py
MAX_LEAF_ROUNDS_OF_MANY_FLIPS = 2

# Times that `trade` is doubled until seams are found for a chart that flips or is stretched. Fewer give up
# charts that one would help; more find no others. tests/charts/test_unwrapping.py
MAX_TRADE_DOUBLINGS = 12

# --- what is stretched or overlaps ---

# Seam length, in square roots of the area, that all stretch of a piece must be worth to search for seams.
SOUGHT_SEAM = 1.0

# L2 stretch beyond 1 that an isometric map of a piece is expected to have by the default `trade`, above which
# the piece gets more seams. Less cuts for what nobody sees; more leaves the texels of large, bumpy meshes
# uneven. benchmarks/generated.py
UNEVEN_STRETCH = 0.03

# Rounds of more seams for even texels. Fewer leave texels uneven; more take as long again for bumps that are
# too small for a seam. benchmarks/generated.py
MAX_EVEN_ROUNDS = 3

MAX_FLIP_ROUNDS = 20  # rounds of cuts for flips, the last ones halvings
MAX_OVERLAP_ROUNDS = 20  # rounds of cuts between overlapping parts; then the chart is halved
MAX_STRETCH_ROUNDS = 64  # rounds of cuts for stretch, the last ones halvings

# Share of a chart's extent, to either side of its middle, within which the shortest seam that halves it is
# sought. Less finds longer seams; with more, halves differ in size, and are cut again.
# tests/charts/packing/test_packing.py
HALVING_BAND = 0.15

# --- the page ---

# Share of the page that the margins of all charts may take; they are narrowed else. Less narrows margins
# that leave room; with more, none is left for charts. tests/charts/packing/test_packing.py
MAX_MARGIN_SHARE = 0.64

# Size of the page, over that of a quick trial, that a full search hardly goes below. Less searches in vain;
# more misses pages that are as good uncut. tests/charts/packing/test_packing.py
SEARCHED_OVER_TRIAL = 0.88

# Share of a page that many charts fill, up to which one of them may be in the way of the others, and is
# tried in parts. Less leaves the page empty; more tries in vain. tests/charts/packing/test_packing.py
MAX_SPARSE_FILL = 0.57
