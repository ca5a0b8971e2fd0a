"""The constants of layouts. `benchmarks/constants.py layouts` halves and doubles each."""

# --- the choice of the layout ---

# Gap of the drawn boundary over its length up to which "auto" draws it. With a larger gap the least squares
# distort less; a smaller limit pays for them where they gain nothing. tests/layouts/test_layouts.py
GAP = 2.5e-3

# Radians by which angles may miss flatness where loops of holes, or a start in the plane, are drawn from
# them, or a corner is placed, seen from its triangle. More lets errors add up to flips; less is rarely
# reached. tests/layouts/test_layouts.py
FLAT_RESIDUAL = 1e-4

# Residual of the constraints up to which triangles are placed one by one, without a system. More lets
# errors add up on the way to a triangle; less is rarely reached. tests/layouts/test_layouts.py
EXACT_RESIDUAL = 1e-7

# --- holes ---

# Gap of a loop over its length up to which a disk with holes is laid out after two solves, by loops that
# are drawn and changed. Loops with larger gaps need further steps; smaller limits pay for these in vain.
# docs/holes.md
LARGEST_HOLE_GAP = 0.1

# Number of holes up to which their loops are drawn. Each takes one more solve: with more of them a factor
# of the least squares takes less time, with fewer it takes more. docs/holes.md
MAX_DRAWN_HOLES = 12

# Conformal energy over the map's area up to which two changes of the loops do. With more, the least squares
# distort less; a smaller limit pays for their factor in vain. benchmarks/constants.py layouts
RELAXED_ENERGY = 3e-5

# --- embeddings ---

# Rates, a tuple, at which weights of convex combinations fall from edge to edge inwards. Without a fall
# long limbs shrink beyond double precision; a steep one presses wide parts to the rim.
# tests/flattening/fallbacks/test_attempts.py
DECAYS = (0.5, 1.0, 0.25, 0.0)

# Exponent up to which such a weight exp(-x) falls. Beyond 700 double precision holds none, and elimination
# takes some of that; less makes deep limbs shrink. tests/flattening/fallbacks/test_attempts.py
MAX_EXPONENT = 600.0

# Rings of triangles around flipped ones that are embedded anew, from narrow to wide. Narrow patches keep
# more of the map, and wide ones succeed more often. tests/flattening/fallbacks/test_attempts.py
PATCH_WIDTHS = (1, 2, 4, 8, 16, 32)

# --- line searches ---

# Share of the promised fall that a step has to bring (Armijo's rule). More shortens good steps; with none,
# steps may go to and fro. tests/layouts/isometry/test_isometric.py
SUFFICIENT_DECREASE = 1e-4

# Halvings after which a step has come to nothing. More find no step that helps; fewer end near collapsed
# triangles too early. tests/layouts/isometry/test_isometric.py
MAX_HALVINGS = 40

# Share of the way to the first collapsed triangle, or vanishing angle, that a step may go. At 1 rounding
# flips triangles; less costs steps. tests/layouts/isometry/test_isometric.py
SHORT_OF_COLLAPSE = 0.9

# --- converged ABF in the plane ---

# Halvings of a step of converged ABF in the plane after which there is none. More find no step that lowers
# the sum of squares; fewer end where angles are at their bounds. tests/angles/steps/test_newton.py
MAX_PLANE_HALVINGS = 25

# Steps after which converged ABF in the plane has failed, and is tried in angles. Fewer end hard input
# early; more only wait for the failure. tests/angles/steps/test_newton.py
MAX_PLANE_STEPS = 60

# Steps within a patch, which is then as near to its minimum as it comes. Fewer leave short steps to the
# whole map; more cost time where they no longer help. benchmarks/constants.py layouts
MAX_PATCH_STEPS = 24

# Damping of the normal equations, as a share of their diagonal. Two springs hold the map already: more
# makes steps too short where triangles are small; with less, factors fail. benchmarks/constants.py layouts
PLANE_DAMPING = 1e-14

# Share of the last step's gain above which steps zigzag along a valley, and the map is moved on along the
# last two. Below, this finds nothing; a higher limit costs steps. benchmarks/constants.py layouts
ZIGZAG_GAIN = 0.3

# Share of a full step from which its gain tells of the next ones, and which a shortened trial has at most.
# A lower one ends the steps early; a higher one costs trials. benchmarks/constants.py layouts
LONG_STEP = 0.5

# Share of a trial's length that the next one has at least. Less trusts the parabola through both too far;
# more costs trials. benchmarks/constants.py layouts
SHORTEST_TRIAL = 0.1

# --- the bounds of its angles ---

# Share of its bound that may be missing to an angle. More lets angles fall further than abf promises; less
# costs corrections of trials. benchmarks/constants.py layouts
BOUND_TOL = 1e-4

# Share of its bound that an angle keeps in any trial; and what a step that lets the sum rise leaves, at
# most, of what is missing to bounds. Less strays from the bounds; at 1 no step is found.
# benchmarks/constants.py layouts
BOUND_SHARE = 0.9

# Corrections of a trial, which bring angles back to their bounds. Fewer shorten steps; more correct what
# rounding made. benchmarks/constants.py layouts
MAX_TRIAL_CORRECTIONS = 2

# Angles that a step keeps at their bounds at most. Others shorten it; more cost dense systems of that size.
# benchmarks/constants.py layouts
MAX_BOUNDS = 200

# Rounds in which these are found, each with those that the step before would break. Fewer leave some
# broken; more find few. benchmarks/constants.py layouts
MAX_BOUND_ROUNDS = 4

# Damping of the system of bounds, as a share of its diagonal: they may depend on each other. With less the
# factor fails; with more angles miss their bounds. benchmarks/constants.py layouts
BOUND_DAMPING = 1e-12

# --- its patches ---

# Relative change of an angle by a step from which a patch is laid around its triangle. Less makes patches
# large; with more, short steps of the whole map do their work. benchmarks/constants.py layouts
CURVED_CHANGE = 0.1

# Rings of triangles around these that belong to the patch. Fewer leave it no room to move; more cost time.
# benchmarks/constants.py layouts
CURVED_PATCH_RINGS = 4

# Share of all vertices that patches may have. Larger ones cost as much as a step of the whole map; a
# smaller limit leaves their work to these. benchmarks/constants.py layouts
LARGEST_CURVED_PATCHES = 1 / 8

# Gain that is left to further steps in a patch, over that of the whole map. More ends them early; less
# polishes what the next step changes. benchmarks/constants.py layouts
PATCH_GAIN = 0.1
