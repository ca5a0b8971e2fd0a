"""The constants of isometric maps. `benchmarks/constants.py layouts.isometry` halves and doubles each."""

import numpy as np

# --- the energy ---

# Height over the longest side to which thinner triangles are opened, and the share of their chart's area
# that all of this may take. Less leaves the derivatives no digits; more is seen.
# tests/layouts/isometry/test_isometric.py
OPENING = 1e-6

# --- Newton's method ---

# Steps after which the method ends, though the energy still falls, and the message says so. Fewer end hard
# input early; more cost time where each step gains little. tests/layouts/isometry/test_isometric.py
MAX_NEWTON_STEPS = 200

# Fall of the energy by a step, over the energy, below which it has stalled for any tolerance. More leaves
# stretch that can be measured; less costs steps of rounding. tests/layouts/isometry/test_isometric.py
STALLED_FALL = 1e-8

# Fall that a step promises, over the energy, below which it is not made. Less makes steps of rounding
# alone; more leaves a stalled map where one step more is worth it. tests/layouts/isometry/test_isometric.py
NEGLIGIBLE_FALL = 1e-10

# Factor by which a step is lengthened as long as the energy falls. A larger one overshoots near an isometry,
# a smaller one needs more looks at the energy; without it, there are up to a half more steps.
# benchmarks/constants.py layouts.isometry
GROWTH = 1.5

# Share of the unweighted energy that may be left to further steps where the weighted one takes over. Less
# lowers what is not asked for; with more, or without it, there are up to twice as many steps.
# benchmarks/constants.py layouts.isometry
UNWEIGHTED_TOL = 0.05

# Damping of the Hessian, as a share of its diagonal: the energy does not change when a map is moved or
# turned. With less its factor fails; with more steps are short. benchmarks/constants.py layouts.isometry
DAMPING = 1e-9

# --- SLIM ---

# Iterations of SLIM after which the guarantee's map is looked at. Fewer pay for the look; more miss the
# best map before rounding flips a triangle. tests/flattening/fallbacks/test_attempts.py
SLIM_CHUNK = 5

# Chunks after which SLIM ends. It stalls before, but for maps whose scale varies by nearly all digits;
# fewer leave these more distortion. tests/flattening/fallbacks/test_attempts.py
MAX_SLIM_CHUNKS = 60

# Relative fall of F/3nt in such a chunk below which SLIM is at its end. More leaves distortion; less costs
# iterations for little of it. tests/flattening/fallbacks/test_attempts.py
SLIM_STALLED_FALL = 2e-3

# --- pins ---

# Stiffnesses of the springs from vertices to pins, one after the other; the energy of the surface is about
# 1. With larger ratios vertices jump, and steps are short; smaller ones cost steps.
# tests/layouts/test_pins.py
STIFFNESSES = 10.0 ** np.arange(0, 11, 2)

# Newton steps for each stiffness. Fewer leave pins unmet that could be met; more wait for those out of
# reach. tests/layouts/test_pins.py
MAX_PINNED_STEPS = 40

# Distance of a vertex from its pin, where the surface has the area one, from which it is put there. A
# larger one may flip triangles; a smaller one is below what springs reach. tests/layouts/test_pins.py
PINS_MET = 1e-6

# The correlation of the free map with its pins below which the surface gets the size of the pins, not that
# of the best fit, which vanishes. With less, maps collapse whose pins nothing meets; with more, pins that
# bend the map get it too large. tests/flattening/test_mirrored_pins.py
WEAK_FIT = 0.3
