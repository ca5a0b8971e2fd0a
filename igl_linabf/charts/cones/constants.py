"""The constants of cones. `benchmarks/constants.py charts.cones` halves and doubles each."""

from math import pi

# --- where cones are, and how many ---

# Number of cones that lowering the expected L2 stretch by 1 is worth, if nothing else is asked for. With
# less, limbs shrink; with more, cones hardly help. docs/cones.md
CONE_TRADE = 30.0

# Cones that are found one by one on any surface; beyond, and beyond twice its Euler characteristic, several
# at once. So many may also be added in a row while no triangles can have the angles. With less, cones are
# worse places; with more, surfaces with many limbs take longer. tests/charts/cones/test_cones.py (all
# limbs)
SINGLE_CONES = 100

# Cones that are there for each one that is added at once. With fewer, those added at once are near each
# other's limbs; with more, they are found one by one. tests/charts/cones/test_cones.py (all limbs)
CONES_PER_NEW_CONE = 16

# Values of Green's functions, one at each node for each cone, up to which cones are found: 1.6 GB. More
# take memory; less leaves limbs of large surfaces without cones. tests/charts/cones/test_cones.py (all
# limbs)
MAX_GREEN_VALUES = 200_000_000

# Interior vertices to each cone, at least, beyond those that are found one by one. Fewer make cones of the
# vertices of coarse meshes; more leave limbs of these without cones. benchmarks/constants.py charts.cones
MIN_VERTICES_PER_CONE = 8

# Cones in a row that do not pay, after which no more are tried. Fewer stop before limbs that need two
# cones; more take time in vain. benchmarks/constants.py charts.cones
MAX_IDLE_CONES = 4

# L2 stretch, with the price of cones, from which on more cones are tried though the last ones did not pay:
# limbs get theirs one by one. It is also the price of cones with bad angles. Less leaves limbs without
# cones; more tries cones in vain. tests/charts/cones/test_cones.py (all limbs)
TOLERABLE_STRETCH = 3.0

# --- angles at cones, radians ---

# The unit of quarter cones, and of what closed paths turn by with them: a definition.
QUARTER_TURN = pi / 2

# Angle sum of a cone below which another one is put near it. Less leaves spikes, in which triangles are
# needles; more takes cones where none are needed. tests/charts/cones/test_cones.py (a long horn)
MIN_CONE_ANGLE = pi / 3

# Angle of the triangles at a cone, on average, above which another one is put near it, and to which no cone
# moves. More leaves triangles nearly flat; less takes cones where none are needed.
# tests/charts/cones/test_cones.py (angles that triangles can have)
MAX_ANGLE_AT_CONE = 0.75 * pi

# --- curvatures in quarter turns ---

# Of a cone at most, since its angle sum is at least one of the four quarter turns.
MAX_QUARTERS = 3

# Quarter turns that each triangle at a cone may take: 120 degrees. More makes triangles nearly flat; less
# leaves cones no room for what Gauss-Bonnet asks of them. benchmarks/constants.py charts.cones
QUARTERS_PER_TRIANGLE = 120 / 90

# The same where cones have so little room that a few of many triangles would have to take what all others
# may not: 150 degrees. tests/charts/cones/test_cones.py (few quarter cones)
QUARTERS_PER_WIDE_TRIANGLE = 150 / 90

# Growth of the log stretch by quarter turns from which on wider triangles are the lesser evil, if they
# lower it by as much. Less widens triangles in vain; more stretches the map.
# tests/charts/cones/test_cones.py (few quarter cones)
WIDENING_LOG_STRETCH = 1.0

# Nodes, evenly chosen, from which the stretch of cones in quarter turns is estimated. Fewer misjudge limbs;
# more take time in proportion. benchmarks/constants.py charts.cones
STRETCH_SAMPLES = 4_000

# Exchanges of a quarter turn between two cones. Fewer leave stretch where cones are many; more hardly gain,
# as each lowers the stretch less than the last one. benchmarks/constants.py charts.cones
MAX_EXCHANGES = 500

# Share of the squared stretch to which an exchange of a quarter turn has to lower it. More goes on for
# nothing that shows; less leaves stretch. benchmarks/constants.py charts.cones
EXCHANGE_GAIN = 0.999

# --- closed paths that turn by quarters ---

# Growth of the log stretch that is as bad as one of F/3nt by 1, where quarter turns are exchanged for it.
# Less distorts handles; more stretches the map. benchmarks/cones.py
DISTORTION_PER_LOG_STRETCH = 30.0

# Exchanges of a quarter turn, those of the least stretch, that are tried in pairs. Fewer miss what suits
# the handles; the time grows with their square. benchmarks/constants.py charts.cones
PAIRED_EXCHANGES = 160

# Pairs, the best ones by a quadratic form, whose stretch is estimated from all samples. Fewer miss the best
# one; more take time in proportion. benchmarks/constants.py charts.cones
ESTIMATED_PAIRS = 150

# --- cones that move ---

# Share of edges whose cotangents sum to zero or less, above which cones stay, since what is expected of moves
# does not come true among needles. More moves cones to worse places; less distorts handles.
# benchmarks/constants.py charts.cones
MAX_THIN_SHARE = 0.2

# Nodes from which cones move: fewer are hardly any to move to. With less, cones of coarse meshes move in
# vain; more distorts handles. benchmarks/constants.py charts.cones
MIN_NODES_OF_MOVES = 1_000

# Log stretch above which cones stay, since what moves change is expected to second order only. More moves
# them to worse places; less distorts handles. benchmarks/constants.py charts.cones
MAX_MOVED_LOG_STRETCH = 3.0

# Rounds of moves, each within balls around where cones then are. Fewer leave cones on their way; more take a
# factor each for what hardly gains. benchmarks/constants.py charts.cones
MAX_MOVE_ROUNDS = 4

# Sweeps over all cones in a round. Fewer leave cones where others no longer want them; more are rarely
# needed. benchmarks/constants.py charts.cones
MAX_SWEEPS = 30

# Log stretch that missing quarter turns have to cost, for cones to move. Less takes time for what does not
# show; more distorts handles. benchmarks/constants.py charts.cones
MIN_MISSING_COST = 0.05

# Growth of the log stretch that is as bad as one of F/3nt by 1, where cones move for it: more than for
# exchanges, since missing turns also make needles. Less distorts handles; more stretches the map.
# benchmarks/cones.py
MISSING_TURN_PER_LOG_STRETCH = 200.0

# F/3nt that a quarter turn costs at most, since the triangles right at cones give way for it. More lets
# cones go far for thin handles; less leaves them distorted. benchmarks/constants.py charts.cones
MAX_QUARTER_DISTORTION = 0.02

# Share of the trace of these costs that is added to their diagonal, for a matrix that has a Cholesky
# factor. Less is lost to rounding; more changes the costs. benchmarks/constants.py charts.cones
COST_DAMPING = 1e-12

# Radius, over the square root of the surface's area, of the balls within which cones move in one round.
# Less needs more rounds; more goes beyond where expectations hold. benchmarks/constants.py charts.cones
BALL_RADIUS = 0.3

# Share of the way to the nearest other cone that a cone may go in one round. With half of it and more, two
# cones meet; less needs more rounds. benchmarks/constants.py charts.cones
MAX_WAY_TO_CONE = 0.4

# Vertices of a ball that are tried, evenly chosen if it has more. Fewer miss the best one; more take time
# in proportion. benchmarks/constants.py charts.cones
MAX_BALL_VERTICES = 1_500

# Vertices of a ball to which slopes are fitted. Fewer are less exact; more take time in proportion.
# benchmarks/constants.py charts.cones
FITTED_VERTICES = 200

# Share of the largest singular value below which a direction of a ball has no slope: a ball of a surface
# has two directions, and hardly a third one. Less fits noise; more loses a direction.
# benchmarks/constants.py charts.cones
SLOPES_RTOL = 0.05

# Cost, as log stretch, that moves have to save in a round, for another one, and in all. Less goes on for
# nothing that shows; more distorts handles. benchmarks/constants.py charts.cones
MIN_MOVE_GAIN = 0.01

# Log stretch that a sweep over all cones has to gain, for another one. More ends early; less goes on for
# nothing that shows. benchmarks/constants.py charts.cones
MIN_SWEEP_GAIN = 1e-4

# --- seams and maps ---

# Nodes from which on the factor that gave the cones their angles preconditions the first step of linear
# ABF. With less, a factor of the step's own metric takes little time and saves steps; with more, it takes
# longer. benchmarks/cones.py --speed
MIN_KNOWN_FACTOR_NODES = 5_000

# Share of edges whose cotangents sum to zero or less, up to which it does. With more, it needs many
# iterations; a lower limit takes time for the other factor. benchmarks/cones.py --speed
MAX_KNOWN_FACTOR_THIN_SHARE = 0.15

# Residual of the angle sums, radians, above which no map has these cones, and flips are not a matter of the
# layout. More calls that a bad map; less refuses cones whose map is only not exact.
# tests/charts/cones/test_cones.py (refused)
MAX_ANGLE_RESIDUAL = 0.5
