"""The constants of packing. `benchmarks/constants.py charts.packing` halves and doubles each."""

# --- distances and pages ---

# Texels between two charts, if a resolution is given and nothing else. With fewer than 2, two charts share
# texels of a bilinear lookup; with more, the page holds less. tests/charts/packing/test_packing.py
DEFAULT_PADDING = 2.0

# Share of the page's side between two charts, if no resolution is given: 2 texels of 400. With less,
# coarser textures bleed from chart to chart; with more, the page holds less.
# tests/charts/packing/test_packing.py
DEFAULT_MARGIN = 0.005

# Share of the page's side that may be asked for between two charts. With more, hardly a hundred charts
# would find room; with less, wide margins are refused. tests/charts/packing/test_packing.py
MAX_GAP = 0.1

# Pages side by side, as UDIM numbers its tiles: tile 1001 + k is at column k % 10. With another number,
# other programs look for pages elsewhere. tests/charts/packing/test_packing.py
UDIM_ROW = 10

# --- outlines ---

# Area of a part's map over its area on the surface, up to which it has none, and no outline. Less divides
# by rounding; more loses parts that are only small. tests/charts/packing/test_packing.py
MIN_MAP_AREA = 1e-12

# Directions in which the outermost points of a chart are taken for its convex hull. Fewer make the hull too
# small; more take time for less than 1 % of its area. benchmarks/constants.py charts.packing
HULL_DIRECTIONS = 32

# --- a single chart ---

# Turns of a quarter that are tried besides those of its hull's sides, for the smallest square around it.
# Fewer miss it by more; more take time for less than 0.1 %. tests/charts/packing/test_packing.py
SINGLE_CHART_TURNS = 1_000

# Points of its hull that are turned, evenly chosen if it has more. Fewer miss the outermost ones; more take
# memory, by the number of turns. tests/charts/packing/test_packing.py
MAX_HULL_POINTS = 2_000

# --- how much is tried ---

# Number of charts up to which they are turned twice as finely, and moved if a texture is asked for. With
# more charts, this takes seconds; a lower limit leaves gaps on the page. benchmarks/constants.py
# charts.packing
MAX_MOVED_CHARTS = 24

# Number of charts up to which three orders are tried instead of two, and two layouts on the fine grid
# instead of one. More charts take longer; a lower limit leaves gaps. benchmarks/constants.py charts.packing
MAX_REORDERED_CHARTS = 40

# Share of the area of all charts up to which one only fills gaps: it is placed as a rectangle, and one of
# many is not cut. Less loses what its shape gains to rounding, since it has but few cells of FINE_GRID, and
# takes time; more leaves gaps. tests/charts/packing/test_packing.py
MIN_SHAPED_AREA = 1 / 1200

# Share of the narrowest rectangle around it that a chart fills, from which on it is turned as a rectangle,
# by quarters only. Less misses turns of others; more tries turns in vain.
# tests/charts/packing/test_packing.py
RECTANGLE_FILL = 0.9

# Turns of each chart on coarse grids; twice as many of a few charts. Fewer leave gaps; more take time in
# proportion. benchmarks/constants.py charts.packing
COARSE_TURNS = 8

# Turns of each chart among which moves choose. Fewer leave gaps; more take time to draw.
# benchmarks/constants.py charts.packing
MOVE_TURNS = 32

# --- grids: cells along a page's side ---

# Of the grid on which orders are compared. Fewer mistake the best one; the time grows with their square.
# benchmarks/constants.py charts.packing
COARSE_GRID = 64

# Of the grid on which moves, and cuts for a fuller page, are tried. Fewer lose what these gain to rounding;
# the time grows with their square. benchmarks/constants.py charts.packing
TRIAL_GRID = 96

# Of the grid on which charts come to their places. Fewer leave up to a cell between charts; the time grows
# with their square. benchmarks/constants.py charts.packing
FINE_GRID = 448

# --- the layout on one page ---

# Share of the page that charts are expected to cover. It sets the scale of the first grid: with more, the
# layout is larger than its page; with less, cells are coarse. benchmarks/constants.py charts.packing
EXPECTED_FILL = 0.62

# Side of the grid on which a layout grows, over the page that it is expected to take; and by how much it is
# larger at each further trial. Less needs more trials; more searches empty cells. benchmarks/constants.py
# charts.packing
GROWING_ROOM = 1.3

# Charts that all moves together place again: so few charts are moved more often than many. Fewer leave
# gaps; more take time in proportion. benchmarks/constants.py charts.packing
MAX_MOVED_PLACES = 400

# Moves of charts at random, however few there are. Fewer leave gaps; more hardly find a smaller square.
# benchmarks/constants.py charts.packing
MAX_MOVES = 100

# Side of a layout over the best one's, on the coarse grid, up to which it is tried on the fine one. Less
# misses those that a fine grid favours; more takes time. benchmarks/constants.py charts.packing
CLOSE_SIDE = 1.02

# Share by which the page of such a trial is larger than what it needs, doubled each time. Less needs more
# trials; more widens gaps. benchmarks/constants.py charts.packing
FINE_SLACK = 0.002

# Such trials of one layout. Fewer give up layouts that a larger page holds; with gaps as wide as the page
# allows none ever does, so that without a limit trials would not end. tests/charts/packing/test_packing.py
MAX_FINE_TRIALS = 8

# --- the side of several pages ---

# Halvings of the interval of sides between pages that hold the charts and those that do not. Each halves
# what is lost, from half a side on, and takes another search. tests/charts/packing/test_packing.py
SIDE_HALVINGS = 7

# Side of pages over the least one, beyond which charts do not fit for their gaps. Less refuses charts with
# wide gaps; more only takes time. tests/charts/packing/test_packing.py
MAX_SIDE_RATIO = 1e3

# --- cuts for a fuller page ---

# Number of charts up to which all are on the page of trials; of more, the largest ones. Fewer are cut
# though others fill their gaps; more take time. tests/charts/packing/test_packing.py
MOST_TRIAL_CHARTS = 30

# Cuts for one page. More make many small charts of one; fewer leave limbs. benchmarks/constants.py
# charts.packing
MAX_PAGE_CUTS = 8

# Directions of the lines across a chart along which it may be cut. Fewer miss the narrow places of limbs;
# more take time. benchmarks/constants.py charts.packing
LINE_DIRECTIONS = 8

# Lines in each direction, evenly across the chart. Fewer miss the narrow places of limbs; more take time.
# benchmarks/constants.py charts.packing
LINES_ACROSS = 7

# Lines, the most promising ones, for which the parts are packed. Fewer miss the best one; more take time.
# benchmarks/constants.py charts.packing
MAX_PACKED_LINES = 8

# Lines of these beside which the shortest seam is sought, and its parts are packed. Fewer miss the best
# one; more take time. benchmarks/constants.py charts.packing
MAX_SEAM_LINES = 3

# Length of the shortest seam beside a line over that of the edges that the line crosses, as it is expected.
# Less packs lines in vain; more gives up cuts that pay. benchmarks/constants.py charts.packing
SEAM_PER_LINE = 0.8

# What a line may cost over what the seam beside it may cost. Less gives up cuts that pay; more seeks seams
# in vain. benchmarks/constants.py charts.packing
LINE_TOLERANCE = 1.1

# Share of a page that charts are hoped to cover. Less gives up cuts that pay; more packs lines in vain.
# benchmarks/constants.py charts.packing
BEST_FILL = 0.77

# Area that charts are expected to take of a page, over that of their convex hulls. With less or more, the
# chart that wastes most of the page is mistaken. benchmarks/constants.py charts.packing
PAGE_PER_HULL = 1.25

# Side of a page that has room for a chart, over the diagonal of the rectangle around it: a square's
# diagonal holds about that. Less hides what long charts waste; more exaggerates it. benchmarks/constants.py
# charts.packing
PAGE_PER_DIAGONAL = 0.7

# Squares along a chart whose connected polygons are taken as one, if they are many, to look for lines.
# Fewer blur lines; more take time. benchmarks/constants.py charts.packing
LINE_GRID = 64

# Share of the chart's width within which the shortest seam beside a line is sought. Less finds longer
# seams; more finds parts that are not what was tried. benchmarks/constants.py charts.packing
SEAM_BAND = 0.04

# --- charts larger than a page ---

# Share of a page's side that a chart may have: cells of the grid lose the rest. With more, charts that were
# not cut do not fit; with less, charts are cut in vain. tests/charts/packing/test_packing.py
MAX_CHART_SIDE = 0.98
