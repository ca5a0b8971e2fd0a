"""Constants of packing. `benchmarks/constants.py charts.packing` halves and doubles each of them."""

# Distances

# Share of a page's side that is left free around each chart by default. Less lets bilinear filtering mix
# neighbours; more leaves pages emptier. benchmarks/unwrap.py prints the fill.
MARGIN = 0.005

# Texels between two charts by default. A bilinear lookup that meets two charts mixes them if there are fewer;
# more leave pages emptier. tests/charts/packing/test_packing.py counts the charts at each texel.
PADDING = 2.0

# Share of a page's side that may be asked for between two charts. Of more, a page holds less than a hundred
# charts; less would refuse coarse textures. tests/charts/packing/test_packing.py asks for it.
WIDEST_GAP = 0.1

# Rounding error of coordinates in cells, of gaps and of a map's area. Less lets rounding move a chart into a
# gap; more takes gaps too wide and drops tiny parts. tests/charts/packing/test_packing.py measures gaps to
# this.
PACKING_ROUNDING = 1e-9

# Numbers of charts

# Charts up to which a layout is searched with twice the directions and, for a texture, with moves; and of
# which one may be cut. More take too long; fewer leave pages emptier. Both are in
# tests/charts/packing/test_packing.py: moves of six charts, a cut of a cross beside 45 squares.
FEW_CHARTS = 24

# Charts up to which all three orders are tried, and the two best layouts on the fine grid; one less of each
# beyond. More take longer; fewer leave pages emptier. `benchmarks/constants.py charts.packing --only
# SOME_CHARTS`.
SOME_CHARTS = 40

# Charts up to which all are packed by their shape. Of more, small ones are packed as rectangles, which is
# faster, but fills less. tests/charts/packing/test_packing.py: the fill of 400 charts.
MOST_SHAPED = 100

# Charts packed by their shape where small ones are rectangles. Fewer leave pages emptier; more take longer.
# tests/charts/packing/test_packing.py: the fill of 400 charts.
LARGEST_SHAPED = 60

# Share of the area of all charts, above which one is large. Of many charts, smaller ones are packed as
# rectangles, and not cut: they fill gaps anyway. tests/charts/packing/test_packing.py: the fill of 400
# charts.
SMALL_CHART = 1 / 400

# Share of the rectangle around a chart, above which it is taken as that rectangle, and turned by quarter
# turns only. Below, other turns may fit it into bays.
# test_rectangles_are_turned_by_quarters_where_they_fit_so.
RECTANGLE_FILL = 0.9

# Grids

# Directions in which a chart is packed, and in which lines across it are tried as cuts. Fewer leave pages
# emptier; more take longer. `benchmarks/constants.py charts.packing --only DIRECTIONS`.
DIRECTIONS = 8

# Cells along the side of a page on which all orders are tried, and squares along a chart for its first cuts.
# Fewer choose worse orders; more take longer. `benchmarks/constants.py charts.packing --only COARSE_CELLS`.
COARSE_CELLS = 64

# Cells along the side of the page on which moves and cuts are tried. Fewer hide gains that are less than a
# cell; more take longer. `benchmarks/constants.py charts.packing --only MOVE_CELLS`.
MOVE_CELLS = 96

# Cells along the side of the page that the best layouts end on: a coarse cell is parted in 7.
FINE_CELLS = 7 * COARSE_CELLS

# Cells along the side of pages for many charts or of a given side: a cell of the moves is parted in 4.
PAGE_CELLS = 4 * MOVE_CELLS

# Share of a page that charts are expected to fill, which sets the size of the first cells. Less gives finer
# cells, which take longer; more gives coarser ones. `benchmarks/constants.py charts.packing --only
# EXPECTED_FILL`.
EXPECTED_FILL = 0.62

# Ratio of the sides of two pages that are tried one after the other, if the first one is too small. It
# changes only how often and on how large a page is packed again: benchmarks/unwrap_time.py.
PAGE_GROWTH = 1.5

# Search

# Relative change of a page's side by a change of grids. Layouts nearer than this to the best coarse one are
# tried on the fine grid, and charts shorter than a page by less than this are cut. More tries more, and cuts
# more.
GRID_TOLERANCE = 0.02

# Relative step by which a page that does not hold its gaps is enlarged; doubled each time. Larger steps leave
# pages emptier, smaller ones take longer. test_the_scale_is_searched_finely.
SIDE_STEP = GRID_TOLERANCE / 10

# Moves at random of at most four charts; of more, as many as place four times this number of charts. Fewer
# leave textures emptier; more take longer than half a second.
# test_moves_fill_a_texture_better_than_the_first_layout.
MOST_MOVES = 100

# Cuts

# Area of a page that holds charts, over that of their convex hulls. With more, less convex charts are cut;
# with less, a cut seems to gain less. `benchmarks/constants.py charts.packing --only HULL_ROOM`.
HULL_ROOM = 1.25

# Side of a page over the diameter of the longest chart that it holds: about a diagonal. With more, long
# charts are cut first. `benchmarks/constants.py charts.packing --only LEAST_SIDE`.
LEAST_SIDE = 0.7

# Lines across a chart beside which the shortest seams are sought, the most promising ones. Fewer miss good
# cuts; more take longer. `benchmarks/constants.py charts.packing --only SHORTENED_CUTS`.
SHORTENED_CUTS = 3

# Share of a chart's width, on both sides of a line, in which the shortest seam is sought. In a wider band
# seams are shorter, but parts differ more from what was tried. `benchmarks/constants.py charts.packing --only
# CUT_BAND`.
CUT_BAND = 0.04

# The same around the middle of a chart that is larger than a page. In a wider band seams are shorter, but
# parts are less even, and more are needed. test_a_chart_larger_than_a_page_is_cut_until_its_parts_fit.
HALVING_BAND = 0.15

# Capacity of the longest edge in a minimum cut: lengths are rounded to integers. Less chooses among short
# edges at random; more comes near to the limits of integers. `benchmarks/constants.py charts.packing --only
# FLOW_UNITS`.
FLOW_UNITS = 1 << 20
