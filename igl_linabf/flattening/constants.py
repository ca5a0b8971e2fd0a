"""The constants of flattening. `benchmarks/constants.py flattening` halves and doubles each."""

# --- tolerances of the methods ---

# Radians of the angle constraints below which linear ABF has nothing left to do, and the sides of a seam
# match. Less is below rounding on fine meshes; more leaves seams that are seen.
# tests/flattening/test_methods.py, tests/charts/cones
TOL = 1e-8

# Relative change of angles at which converged ABF ends. With more F/3nt loses its fifth digit; less costs
# steps that nobody sees. tests/angles/steps/test_newton.py
ABF_TOL = 1e-4

# --- the isometric map ---

# Default exponent of the areas' term in the isometric energy. At 1.5 L2 stretch is least: less keeps
# angles, and more keeps areas. tests/layouts/isometry/test_isometric.py
AREA_WEIGHT = 1.5

# Largest exponent that may be asked for. Up to it areas become more even; beyond, they hardly do, and steps
# become short. tests/layouts/isometry/test_isometric.py
MAX_AREA_WEIGHT = 8.0

# Default share of the isometric energy that may be left to further steps. Less costs steps that nobody sees;
# more leaves texels uneven that could be even. tests/layouts/isometry/test_isometric.py
ISOMETRIC_TOL = 1e-3

# --- the shape of the boundary ---

# Radians by which angle sums at the boundary may be off: those asked for, from Gauss-Bonnet; those reached
# for a circle, on which vertices are put anyway. Less refuses rounded input and costs steps; more moves
# vertices visibly. tests/flattening/test_boundary_shapes.py
BOUNDARY_TOL = 1e-6

# Share of the boundary's length, to either side of a corner of a rectangle, over which its turning is
# summed. Less is misled by jagged boundaries; more lets corners merge.
# tests/flattening/test_boundary_shapes.py
CORNER_WINDOW = 0.02

# --- many meshes ---

# Triangles up to which a mesh shares its system with others. Larger ones take as long alone; with a smaller
# limit, meshes that would gain are left alone. benchmarks/many.py
LARGEST_TOGETHER = 10_000

# --- other methods ---

# Square root of the area to which a surface is scaled for igl's spectral LSCM. On much larger or smaller
# surfaces its search for the eigenvector fails. tests/flattening/test_baselines.py
SCP_SIZE = 1 / 32

# --- surfaces with cones ---

# Radians of a triangle's largest angle up to which it is scaled conformally; by how much an angle that was
# larger may grow, is the next one. Larger ones make steps short; a smaller limit leaves more to them.
# tests/charts/cones
LARGEST_SCALED_ANGLE = 2.0

# Radians by which the largest angle of a scaled triangle may exceed its own on the surface, if it exceeds
# the limit above. More makes steps short; less leaves obtuse triangles unscaled. tests/charts/cones
LARGEST_WIDENING = 0.2

# Steps after converged ABF until the sides of seams match, at most. Fewer leave seams that are seen; more
# lead away from its minimum, and rarely gain. tests/charts/cones
MAX_STEPS_TO_SEAMS = 3

# The least length of a unit direction projected to the surface and averaged in the map, at which it turns
# the map. Below, rounding and the mesh would choose the turn; with more, slanting surfaces are refused.
# tests/flattening/test_upright.py turns maps of a dome and of a flat plate.
LEAST_UP = 0.01

# The share of the triangles of pins that are turned over against the free map, from which on the pins are
# mirrored. With less, pins at random are refused; with more, a circle pinned clockwise gives flipped maps
# of ragged surfaces. tests/flattening/test_mirrored_pins.py, tests/layouts/test_pins.py
MIRRORED = 0.9

# The triangles of pins that are looked at. With fewer, chance decides; with more, it takes longer than
# needed. tests/flattening/test_mirrored_pins.py
MOST_PINNED_TRIANGLES = 2000

# The L2 stretch of a valid map from which on it is warned of. With less, maps of heads and limbs are, which
# may be wanted as they are (a camel's head has 16); with more, those of long tubes are not.
# tests/flattening/test_stretched.py
MOST_STRETCH = 100.0

# Vertices from which distances are measured to find the scale at which a map keeps them best. With fewer, the
# scale is off by more than a hundredth, and the error by more than 0.0005; more take longer, 3 ms each.
# tests/measures/test_distances.py
FIT_SOURCES = 250
