"""The constants of flattening. `benchmarks/constants.py flattening` halves and doubles each."""

# --- tolerances of the methods ---

# Residual of the angle constraints, in radians, below which linear ABF has nothing left to do, and both
# sides of a seam match to 1e-8 of a chart's size. Less is below rounding on fine meshes.
# tests/flattening/test_methods.py
TOL = 1e-8

# Relative change of angles at which converged ABF ends. F/3nt then keeps its first five digits; less costs
# steps that nobody sees. tests/angles/steps/test_newton.py
ABF_TOL = 1e-4

# Relative gap of a boundary that is drawn all the same where a map is only looked at. More hides overlaps;
# less costs steps that close the loop. benchmarks/constants.py charts prints the seams.
ROUGH_GAP = 0.2

# --- the isometric map ---

# Default exponent of the areas' term in the isometric energy. At 1.5 L2 stretch is least; less keeps
# angles, more keeps areas. tests/layouts/isometry/test_isometric.py (weight leads from angles to areas)
AREA_WEIGHT = 1.5

# Largest exponent that may be asked for: the areas are even to three digits there, and with more of it
# Newton's method stalls early. tests/layouts/isometry/test_isometric.py
MAX_AREA_WEIGHT = 8.0

# --- the shape of the boundary ---

# Share of the boundary's length, to either side of a corner of a rectangle, over which its turning is
# summed. Less is misled by jagged boundaries; more lets corners merge.
# tests/flattening/test_boundary_shapes.py
CORNER_WINDOW = 0.02

# Radians by which angles that are asked for may miss their sum by Gauss-Bonnet. Less refuses sums of
# rounded angles; more asks for a boundary that no flat map has. tests/flattening/test_boundary_shapes.py
GAUSS_BONNET_TOL = 1e-6

# --- many meshes ---

# Triangles from which a mesh is flattened alone. Larger ones gain nothing in company; with a smaller limit,
# meshes that would gain are left out. benchmarks/many.py prints the seconds of both.
LARGEST_TOGETHER = 10_000

# --- other methods ---

# Square root of the area to which a surface is scaled for igl's spectral LSCM, whose search for the
# eigenvector finds nothing on surfaces a few hundred times larger or smaller.
# tests/flattening/test_baselines.py
SCP_SIZE = 1 / 32

# --- surfaces with cones ---

# Largest angle, in radians, of a triangle that is scaled conformally. Larger ones, if WIDER than on the
# surface, keep their estimate, from which steps converge. tests/charts/cones; less scales fewer triangles.
LARGEST_SCALED_ANGLE = 2.0

# Radians by which the largest angle of a scaled triangle may exceed its own on the surface, if that is
# obtuse.
WIDER = 0.2
