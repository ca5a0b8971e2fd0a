"""The numbers of the steps, and what each decides; `benchmarks/constants.py angles` prints it."""

# Linear steps

# Share of the way to a vanishing angle that a step may take a triangle. With more, angles nearly vanish, and
# the next system is nearly singular; with less, more steps are limited.
# tests/flattening/fallbacks/test_attempts.py.
LONGEST_WAY = 0.7
# Relative residual of the inner solver in a step that others follow. With less, inner steps find digits that
# the next step changes; with more, steps are many. benchmarks/timing.py prints the times.
ROUGH_RTOL = 0.1
# Inner steps up to which the factor of the first step serves the second, too; after a limited step, half as
# many. With fewer, factors cost more than they save; with more, inner steps do. benchmarks/cones.py prints
# the times.
FEW_INNER_STEPS = 8
# Steps in a row, each with a larger residual than the one before, after which angles diverge. With fewer,
# some that would come back are given up; more only take longer. tests/charts/cones/test_cones.py.
GROWING_STEPS = 4

# Conformal corrections

# Corrections in a row, at most; then there is a step. Without it, those that are limited with a known factor
# would never end; with fewer, steps take their place. tests/flattening/fallbacks/test_attempts.py.
MAX_CORRECTIONS = 12

# Residual below which corrections begin. With more, F/3nt rises by a thousandth or more; with less, there
# are more steps. benchmarks/distortion.py prints both.
CORRECTABLE = 0.12
# The same where sums or turnings are prescribed, which change angles more than corrections do. With more,
# corrections are in vain more often; with less, there are more steps. benchmarks/boundaries.py.
CORRECTABLE_PRESCRIBED = 0.25
# Share of the residual that a correction leaves, above which corrections are in vain, and steps go on.
# Below, each at least halves it. benchmarks/cones.py prints the times.
IN_VAIN = 0.5
# Share of the residual that a correction leaves, above which the next one has a new factor. With less,
# factors take more time than corrections; with more, corrections do. benchmarks/cones.py prints the times.
SLOW_CORRECTION = 0.2
# Prescribed sums

# Residual below which lengths around holes mean something, and how far steps to it are solved. With more,
# loops are to become circles of lengths that mean little; with less, steps are more.
# tests/flattening/test_boundary_shapes.py.
LOOPS_CLOSED = 0.3

# Inner steps from which a new factor pays in steps to prescribed sums. With fewer, factors cost more than
# they save; with more, inner steps do. benchmarks/boundaries.py prints both.
MANY_INNER_STEPS = 30

# Converged ABF: anchored steps

# Relative residual of the inner solver in anchored steps, and in steps to a start of feasible ones. With
# less, inner steps find digits that the next step changes; with more, steps are many.
# tests/angles/steps/test_newton.py.
ANCHORED_RTOL = 0.03
# Share of the least change so far above which an anchored step is slow, and later ones are solved further.
SLOW_STEP = 0.7
# Relative residual of the inner solver in slow anchored steps, at least.
LEAST_ANCHORED_RTOL = 0.003
# Relative change of an angle above which slow steps are not solved further: the constraints are not linear.
NEARLY_LINEAR = 1.0
# Anchored steps at most; of feasible ones twice as many.
# tests/angles/steps/test_newton.py asserts how many it takes.
MAX_ANCHORED_STEPS = 30
# Slow steps in a row after which anchored ones end. With fewer, steps that converge are given up; more are
# in vain.
MAX_SLOW_STEPS = 9

# Converged ABF: feasible steps

# Share of its initial value below which no angle falls. With less, systems are singular; with more, more
# angles are held. tests/angles/steps/test_newton.py; the message says it, too.
ANGLE_BOUND = 0.01
# Times that bound: up to here an angle is at it. With less, rounding frees angles; with more, free ones are
# held. tests/angles/steps/test_newton.py.
AT_BOUND = 1 + 1e-6
# Weight of an angle at its bound, relative to a free one's. With more, it moves; with less, systems are
# singular.
HELD_WEIGHT = 1e-12
# Relative residual of the inner solver in feasible and restoring steps. With more, held angles change from
# step to step; with less, inner steps are many. tests/angles/steps/test_newton.py.
FEASIBLE_RTOL = 0.01
# Share of the objective's curvature along an angle below which the constraints' curvature is not trusted.
# With less, steps are too long, and are halved; with more, they are many. tests/angles/steps/test_newton.py.
LEAST_CURVATURE = 0.2
# Changes of the set of held angles in a step, and restoring steps after it, at most. More change little.
MAX_RESTORING_STEPS = 4
# Times the tolerance: relative gain of the objective that may be left to feasible steps. With more, digits
# of F/3nt are lost; with less, steps gain only rounding. tests/angles/steps/test_newton.py.
LEFT_GAIN = 1e-4
# Times the tolerance: relative change of all angles that may be left to further feasible steps. With more,
# F/3nt loses its fifth digit; with less, there are more steps. tests/angles/steps/test_newton.py.
LEFT_TO_STEPS = 4.0
# Triangles times solves and inner steps that the feasible form may take: more than meshes of 10,000 triangles
# need, and some ten seconds on larger ones, which are sooner cut.
MAX_FEASIBLE_WORK = 2e7
# Relative rounding error of the objective. Smaller gains are not believed; with more, true ones are not.
# tests/angles/steps/test_newton.py.
ROUNDING = 1e-13
# Length of a feasible step below which none is found. With more, steps that gain are given up; less gains
# nothing.
LEAST_STEP = 1e-7
# Residual of the start of feasible steps. With more, the objective falls by what is missing; less takes
# longer.
START_RESIDUAL = 1e-9
# Steps to that start at most. With fewer, feasible steps begin off the constraints; more are in vain.
# tests/angles/steps/test_newton.py.
MAX_START_STEPS = 20

# Holonomy angles

# Share of the largest entry of a small dense matrix below which entries are rounding. With less, rounding
# counts as a cost of turnings; with more, true costs are lost. tests/charts/cones/test_cones.py.
HOLONOMY_ROUNDING = 1e-10
