"""The constants of the fallbacks. `benchmarks/constants.py flattening` halves and doubles each."""

# --- linear ABF ---

# Relative residual of the two solves of "auto", and of steps to circles, which others follow. Less costs
# inner steps that a further solve makes up for; more leaves loops open. benchmarks/constants.py flattening
STEP_AND_CHORD_RTOL = 0.1

# Relative residual of a step that no chord follows. Less costs inner steps; more costs further steps.
# benchmarks/constants.py flattening prints the inner steps of both.
ACTIVE_SET_RTOL = 0.01

# Relative residual of a step that corrections in the conformal metric follow. More leaves them too much,
# and they no longer converge; less costs inner steps. tests/flattening/fallbacks/test_attempts.py
CONTINUED_RTOL = 0.03

# Steps after which "auto" gives up linear ABF. Meshes on which it converges take 7 at most
# (tests/flattening/test_methods.py); with fewer allowed, converged ABF would start too early.
MAX_ACTIVE_SET_STEPS = 12

# Steps to prescribed angle sums after which converged ABF takes over. Long chords take up to about 20; more
# steps only delay the message that names the chords. tests/flattening/test_boundary_shapes.py
MAX_STEPS_TO_SUMS = 25

# Residual, in radians, at which steps to a circle end. The outer loop is drawn on it to all digits anyway;
# less costs steps, more moves vertices visibly along the circle. docs/boundaries.md,
# test_boundary_shapes.py
CIRCLE_TOL = 1e-6

# --- previews ---

# Residual at a vertex, in radians, below which no tip of the surface is steep: a preview has nothing to
# show, and none is made. A tip above it shrinks much in the map. benchmarks/constants.py charts
PREVIEW_RESIDUAL = 0.2

# --- converged ABF ---

# Ratio of area scales above which fewer than two digits are left of the shortest lengths, so that converged
# ABF cannot help, either, and is not tried; below, it may. tests/flattening/fallbacks/test_attempts.py
# (deer)
TWO_DIGIT_SPAN = 1e28

# Relative fall of the sum of squares that may be left to further steps in the plane, over the tolerance of
# the angles. Less costs steps; more moves F/3nt beyond its fifth digit. benchmarks/constants.py flattening
PLANE_ABF_GAIN = 1e-3
