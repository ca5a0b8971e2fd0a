"""The constants of layouts. `benchmarks/constants.py layouts` halves and doubles each."""

# --- the choice of the layout ---

# Gap of the drawn boundary over its length up to which "auto" draws it. With a larger gap the least squares
# distort less; a smaller limit pays for them where they gain nothing. tests/layouts/test_layouts.py
GAP = 2.5e-3

# Radians by which angles may miss flatness where loops of holes are drawn from them, or a corner is placed,
# seen from its triangle. More lets errors add up to flips; less is rarely
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
