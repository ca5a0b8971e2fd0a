"""The constants of the fallbacks. `benchmarks/constants.py flattening` halves and doubles each."""

# --- linear ABF ---

# Relative residual of a step that others follow: the first of "auto", its chord, and steps to circles. Less
# costs inner steps that these make up for; more costs further steps. tests/linalg/test_solvers.py
STEP_AND_CHORD_RTOL = 0.1

# Relative residual of a step of the active set. Less costs inner steps; more costs further steps.
# benchmarks/constants.py flattening
ACTIVE_SET_RTOL = 0.01

# Relative residual of a step that corrections in the conformal metric follow. More leaves them too much;
# less costs inner steps. tests/flattening/fallbacks/test_attempts.py
CONTINUED_RTOL = 0.03

# Steps after which linear ABF has failed. It converges in 7 where it does
# (tests/flattening/test_methods.py); fewer give up such meshes, and more wait for the failure.
MAX_ACTIVE_SET_STEPS = 12

# Steps to prescribed angle sums after which converged ABF takes over. Fewer give up hard shapes; more wait
# for the failure. tests/flattening/test_boundary_shapes.py
MAX_STEPS_TO_SUMS = 25

# --- converged ABF ---

# Triangles up to which converged ABF is a fallback of linear ABF. Its steps take longer than cutting a larger
# chart.
LARGEST_FOR_ABF = 20_000

# Ratio of area scales above which lengths differ by nearly all digits, so that converged ABF is not tried.
# More tries it in vain; less gives up maps that it mends. tests/flattening/fallbacks/test_attempts.py
TWO_DIGIT_SPAN = 1e28
