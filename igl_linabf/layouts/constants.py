"""The constants of layouts. `benchmarks/constants.py layouts` halves and doubles each."""

# --- the choice of the layout ---

# Gap of the drawn boundary over its length up to which "auto" trusts it. With larger gaps the least squares
# distort less; smaller limits take them where they cost more and gain nothing.
# tests/layouts/test_layouts.py
GAP = 2.5e-3

# Radians up to which angles are flat enough to be drawn: the loops of holes from them, or a start for steps
# in the plane; and a corner may be off by so much, seen from its triangle's shortest side, where triangles
# are placed one by one. More lets errors add up to flips; less falls back too often.
# tests/layouts/test_layouts.py
FLAT_RESIDUAL = 1e-4

# Residual of the constraints up to which triangles are placed one by one, without a system. On the way to a
# triangle errors add up; less is rarely reached. tests/layouts/test_layouts.py (flat angles ... without a
# system)
EXACT_RESIDUAL = 1e-7

# --- holes ---

# Gap of a hole's loop over its length up to which "auto" lays out by least squares after two solves, and
# begins these with the drawn loops. Loops with larger gaps cross themselves, and more steps follow.
# docs/holes.md
LARGEST_HOLE_GAP = 0.1

# Number of holes up to which their loops are drawn: each takes one more solve, so that with more of them
# the factor of the least squares takes less time. tests/surface, benchmarks/constants.py layouts
MAX_DRAWN_HOLES = 12

# Conformal energy over the map's area up to which two changes of the loops are as good as the least
# squares. More lets distortion through; less costs a factor where nothing is gained.
# benchmarks/constants.py layouts
RELAXED_ENERGY = 3e-5

# --- embeddings ---

# Rates at which the weights of convex combinations fall, from edge to edge further inside, one tried after
# the other. Without a fall, long limbs shrink beyond double precision; with too much, wide parts do.
# tests/flattening/fallbacks/test_attempts.py (any start ends without flips)
DECAYS = (0.5, 1.0, 0.25, 0.0)

# Largest exponent of such a weight exp(-x). Double precision ends at 700, and elimination takes some of
# that; less makes deep limbs shrink. tests/flattening/fallbacks/test_attempts.py (embeddings in a circle
# are valid)
MAX_EXPONENT = 600.0

# Rings of triangles around flipped ones that are embedded anew, one after the other. Narrow patches keep
# more of the map, wide ones succeed more often. tests/flattening/fallbacks/test_attempts.py (the guarantee
# ...)
PATCH_WIDTHS = (1, 2, 4, 8, 16, 32)

# --- line searches ---

# Share of the promised fall of an objective that a step has to bring (Armijo; Nocedal, Wright 2006, page 33
# have this value). More shortens good steps; with none, steps may go to and fro. tests/layouts/isometry
SUFFICIENT_DECREASE = 1e-4

# Halvings after which a step has come to nothing, at 1e-12 of its length. No step that helps is found after
# so many; fewer end searches near collapsed triangles early. tests/layouts/isometry
MAX_HALVINGS = 40

# Share of the way to the first collapsed triangle, or vanishing angle, that a step may go. At 1 triangles
# are lost to rounding; less costs steps. tests/layouts/isometry (no triangle is flipped)
SHORT_OF_COLLAPSE = 0.9

# --- converged ABF in the plane ---

ZIGZAG_GAIN = 0.3
MAX_PLANE_STEPS = 60
MAX_PATCH_STEPS = 24
BOUND_SHARE = 0.9
BOUND_TOL = 1e-4
MAX_CORRECTIONS = 2
TELLING_SCALE = 0.5
SHORTEST_TRIAL = 0.1
LONGEST_TRIAL = 0.5
PLANE_DAMPING = 1e-14
CURVED_CHANGE = 0.1
CURVED_PATCH_RINGS = 4
LARGEST_PATCHES = 1 / 8
PATCH_GAIN = 0.1
MAX_BOUNDS = 200
MAX_BOUND_ROUNDS = 4
BOUND_DAMPING = 1e-12
