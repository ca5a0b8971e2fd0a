"""Constants of cones. test_cones.py is in tests/charts/cones; benchmarks/constants.py sweeps them."""

import numpy as np

# Units
QUARTER_TURN = np.pi / 2
FULL_TURN = round(2 * np.pi / QUARTER_TURN)  # quarter turns

# How many cones

# The number of cones that lowering the L2 stretch by one is worth, by default. With less, fewer cones are
# found and limbs shrink; with more, cones go on into details. test_cones.py compares.
CONE_TRADE = 30.0

# Up to this number, and up to two cones a handle, cones are found one by one; beyond, several at a time. Less
# places some where they help little; more takes one solve a cone longer. test_cones.py: 120 spikes.
CONES_ONE_BY_ONE = 100

# One new cone for so many that are there, where several are placed at a time. With less, more of them land on
# the same limb; with more, many limbs take long. test_cones.py: 120 spikes.
CONES_PER_NEW_CONE = 16

# The number of cones in a row that do not pay, before the search ends. Less misses limbs that pay in pairs;
# more only takes time. `benchmarks/constants.py charts.cones` shows where charts change.
CONES_IN_VAIN = 4

# The most values of Green's functions that are kept, eight bytes each, for one a cone. With less, huge
# surfaces get fewer cones than limbs; with more, memory runs out: one value is held for each node and cone.
MAX_GREEN_VALUES = 200_000_000

# The L2 stretch above which more cones are tried whether they pay or not, and what strained cones cost. Less
# stops before all limbs have cones; more adds needless ones. test_cones.py: 120 spikes, a long horn.
USABLE_STRETCH = 3.0

# Angles at cones

# The angle sum, radians, below which a cone needs another one near it. Below, the map shrinks to needles at
# it; a larger one asks for cones where none is needed. test_cones.py: the long horn.
NARROW_CONE = np.pi / 3

# The mean angle of corners at a cone, radians, above which another cone is placed near it, or none moves to
# it. Corners beyond are nearly flat; a smaller one asks for more cones. test_cones.py: on 3holes.
WIDE_CORNER = 3 * np.pi / 4

# Quarter turns, here 120 degrees, that a corner at a quantised cone takes at most. Less leaves the other
# cones more to take; more flattens triangles. test_cones.py: plates with 16 handles.
QUARTERS_OF_CORNER = 4 / 3

# The same, 150 degrees, where few cones on many handles could take little else and stretch would explode.
# Less leaves that stretch; from two on, triangles collapse. test_cones.py: the sieve.
QUARTERS_OF_CROWDED_CORNER = 5 / 3

# Quantised curvatures and holonomy

# Share of the squared stretch down to which an exchange of quarter turns has to bring it. With less, more
# stretch stays; from one on, rounding alone exchanges. test_cones.py: few cones, many handles.
EXCHANGE_GAIN = 0.999

# Nodes at which stretch is summed, and to which a cone may move, at most; evenly among all. Fewer are less
# exact; more take longer with many cones. `benchmarks/cones.py --speed` prints the time.
SAMPLED_NODES = 4_000

# Log stretch that is as bad as an F/3nt greater by one, where cones exchange quarter turns. Less lets handles
# twist; more lets limbs shrink. test_cones.py: turning handles by quarters costs little.
STRETCH_PER_DISTORTION = 30.0

# Exchanges that are tried in pairs, and pairs whose stretch is computed exactly: those that look best. Fewer
# miss the best pair; more take time, by the square. test_cones.py: handles.
TRIED_EXCHANGES = 150

# Moves of cones; lengths are shares of the root of the surface's area

# The same where cones move: more, since missing holonomy distorts needles most. With less, cones stay where
# they are; with more, they leave the tips of limbs. test_cones.py: 3holes.
STRETCH_PER_MOVE_DISTORTION = 200.0

# F/3nt up to which the triangles right at cones make up for a missing quarter turn. With less, cones move
# little; with more, moves are thought to save more than they do. test_cones.py: 3holes.
NEEDLE_DISTORTION = 0.02

# Radius of the ball within which a cone moves in one round. With less, it stays short of its best place; with
# more, the expected stretch of a move is far off. test_cones.py: 3holes.
MOVE_RADIUS = 0.3

# What moves have to save, of log stretch and missing holonomy: below, no cone moves, and a round is the last.
# Less moves cones for nothing; more leaves distortion at handles. test_cones.py: 3holes.
LEAST_MOVE_GAIN = 0.05

# The maps

# Share of edges whose cotangents sum to zero or less, above which the Laplacian predicts holonomy badly, and
# preconditions badly. Above, no cone moves, and the first step gets a factor of its own metric.
# tests/charts/cones/test_cones.py: surfaces with needles reach their angle sums.
THIN_SHARE = 0.15

# Nodes from which on the first step does without that factor. On smaller surfaces it takes little time and
# saves steps; on larger ones it would double the time. `benchmarks/cones.py --speed` prints it.
LARGE_COMPONENT = 5_000

# What is missing to the angle sums, radians, above which flipped triangles mean that no map has these cones.
# With less, maps that only flip a triangle are refused; with more, wrong ones returned. test_cones.py.
LARGEST_RESIDUAL = 0.5

# Clusters on which the loops around handles are found, at most. With fewer, loops take detours; more take
# longer. `benchmarks/cones.py --speed`: igl_3holes subdivided.
HANDLE_CLUSTERS = 1_000
