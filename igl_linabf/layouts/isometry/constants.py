"""The constants of isometric maps. `benchmarks/constants.py layouts.isometry` halves and doubles each."""

import numpy as np

# --- the energy ---

# Height of a triangle over its longest side to which thinner ones are open_caps, and the share of their
# chart's area that all of this may take. Less leaves the derivatives no digits; more is seen.
# tests/layouts/isometry
OPENING = 1e-6

# --- Newton's method ---

MAX_NEWTON_STEPS = 200
STALLED_FALL = 1e-6
NEGLIGIBLE_FALL = 1e-9
DAMPING = 1e-9

# --- SLIM ---

FAR_FROM_ISOMETRY = 2.0
SLIM_CHUNK_FAR = 2
SLIM_SLOW_FALL = 0.02
SLIM_CHUNK = 5
MAX_SLIM_CHUNKS = 60
SLIM_STALLED_FALL = 2e-3

# --- pins ---

STIFFNESSES = 10.0 ** np.arange(0, 11, 2)
SOFT_SPRINGS = 100.0
MAX_PINNED_STEPS = 40
PINS_MET = 1e-6
