"""The numbers of the angle system, and what each decides: see `benchmarks/constants.py angles`, too."""

# Circles

# Waves along a loop, at most, in which a step to a circle predicts the change of its sums. Fewer leave more
# to later steps; those after it change 1 / 32 of what is missing. tests/flattening/test_boundary_shapes.py.
MOST_WAVES = 32
# Sides of a loop, at least, to a wave that is predicted. With fewer, the wave is no smooth function on the
# loop; with more, short waves are left to later steps. tests/flattening/test_boundary_shapes.py.
SIDES_PER_WAVE = 4

# Logarithms

# Sine of an angle of 0, as in a collapsed triangle; the core's sums take the same. A smaller one has no
# logarithm in double precision; a larger one changes thin triangles. tests/charts/cones/test_cones.py.
SMALLEST_SINE = 1e-75

# The preconditioner

# Ratio of a triangle's eigenvalues of P and s K above which it is a sliver. With less, solves at slivers
# cost more than the inner steps that they save; with more, these are many. benchmarks/timing.py prints the
# times.
SLIVER = 10.0
# The same ratio in small systems, where inner steps are cheap. With less, solves at slivers cost more than
# they save; with more, needles take hundreds of steps. benchmarks/many.py prints the times.
SLIVER_OF_SMALL_SYSTEM = 1000.0
# Rows of a disk's system up to which it is small. Below, preparations that save inner steps, or steps of the
# whole surface, take more time than these; above, less. benchmarks/many.py and timing.py print the times.
LARGE_SYSTEM = 5_000

# Schur columns

# Change of loops, relative to their size, up to which their columns precondition the next system, too. With
# less, they are solved for anew; with more, inner steps are many. benchmarks/uncut.py prints the times.
LOOP_CHANGE = 0.1
# Columns up to which matrices are dense. With fewer, products take longer; with more, the matrices take more
# memory. benchmarks/uncut.py prints the times.
FEW_COLUMNS = 64
# Gaps of loops whose columns are solved for at a time. With fewer, the factor is read more often; with more,
# right-hand sides leave the processor's cache. benchmarks/uncut.py prints the times.
GAPS_AT_A_TIME = 8
# Rows at a time in products with the columns of paths. With fewer, calls take longer than products; with
# more, the rows leave the processor's cache. benchmarks/cones.py prints the times.
PRODUCT_ROWS = 1024
