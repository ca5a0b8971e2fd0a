"""The constants of periodic maps, which `benchmarks/constants.py charts.periodic` halves and doubles."""

# --- which shifts ---

# Radians, or ratio less 1, by which the sides of a seam edge may miss a quarter turn. Less refuses maps whose
# angles are not exact; with more, textures break. tests/charts/cones/test_cones.py
QUARTER_TURN_TOL = 1e-3

# Cost of a shift by itself over the mean cost of one. With less, shifts that cost nothing together run far
# off; more keeps each where it is, whatever bends. tests/charts/cones/test_cones.py
COST_OF_SHIFT = 0.01

# Cost of a shift over the energy of moving the triangles at the seam alone, below which it is rounding. Less
# chooses by rounding; more takes cheap shifts for free ones. tests/charts/cones/test_cones.py
MIN_COST_TOLD = 1e-7

# Partial choices of whole numbers that are kept. Fewer end farther from the nearest ones; more take longer in
# proportion. tests/charts/cones/test_cones.py
BEAM_WIDTH = 256

# Columns that are solved for in one call. Fewer read the factor more often; more take memory.
# tests/charts/cones/test_cones.py
COLUMNS_AT_ONCE = 32

# --- the displacement ---

# Share of its diagonal by which the energy draws displacements to zero. With less, the factor of a surface
# without cones fails; more pulls maps back. tests/charts/cones/test_cones.py
PULL_TO_PLACE = 1e-8

# Area of a triangle of the map over the largest, as which smaller ones count. With less, slivers decide;
# with more, small triangles bend too easily. tests/charts/cones/test_cones.py
MIN_AREA_OVER_LARGEST = 1e-8

# Weight of a change of scale and direction against one of angles. Less scales parts of the map; more shears
# them. tests/charts/cones/test_cones.py
SCALE_WEIGHT = 0.1

# Rounds in which triangles that change much weigh more, as long as some flip. Fewer refuse periods that do;
# more rarely help. tests/charts/cones/test_cones.py
MAX_WEIGHTINGS = 4

# Relative change of a triangle at which it weighs twice as much. Less stiffens half the map; more leaves
# flips where they are. tests/charts/cones/test_cones.py
DOUBLING_CHANGE = 0.3

# --- the period ---

# Halvings of a period that flips triangles, to name one that does not. Fewer name none; more name periods
# too short to be of use. tests/charts/cones/test_cones.py
MAX_PERIOD_HALVINGS = 8

# Packings, each with twice the room around charts, after which these may come too near to each other. Fewer
# warn of it; more fill the page less. tests/charts/cones/test_cones.py
MAX_ROOMS = 4

# Share of the gap by which rounding may narrow it. With less, charts that are packed closely are packed
# again; more lets them come nearer than was asked for. tests/charts/cones/test_cones.py
GAP_ROUNDING = 1e-6
