"""Constants of periodic maps. `benchmarks/constants.py charts.periodic` halves and doubles each of them."""

# Partial choices of shifts that are kept while shifts are chosen one after another. Fewer end on shifts that
# need more energy; more take longer. test_whole_numbers_are_the_nearest_ones_of_a_form.
KEPT_CHOICES = 256

# Cost of a shift by itself, over the mean cost of one. With less, shifts that cost nothing get large; with
# more, maps move farther than they need. `benchmarks/constants.py charts.periodic --only SHIFT_COST`.
SHIFT_COST = 0.01

# Energy of a change of a triangle's scale and direction, over that of the same change of its angles. With
# less, scales vary more; with more, angles do. test_a_texture_of_the_period_goes_on_across_quarter_seams
# bounds both.
SCALE_STIFFNESS = 0.1

# Relative change of a triangle at which it weighs twice as much when some flip. With less, all triangles near
# to a flip stiffen; with more, more rounds are needed.
# test_a_period_that_flips_triangles_is_refused_with_one_that_does_not.
DOUBLING_CHANGE = 0.3

# Rounds in which triangles are weighed by how much they change, as long as some flip. Fewer leave flips that
# could be avoided; more take longer. test_a_period_that_flips_triangles_is_refused_with_one_that_does_not.
WEIGHING_ROUNDS = 4

# Relative rounding error of energies, areas and distances. Energies below are not told from zero, and smaller
# areas count as this. Far more changes maps; far less divides by zero.
# test_triangles_between_three_cones_have_a_period_too.
PERIODIC_ROUNDING = 1e-8

# Columns that are solved for at once. It changes only memory and time: each column has a number for each
# vertex.
SOLVED_COLUMNS = 32

# Times that the room around charts is doubled, if a period moves them too near to each other. More leave
# pages empty; of fewer, parts of charts lie over others. test_charts_that_a_period_moves_stay_apart.
ROOM_DOUBLINGS = 4

# Times that a period by which triangles flip is halved, to tell one by which none do. Of fewer, the message
# may have none. test_a_period_that_flips_triangles_is_refused_with_one_that_does_not.
PERIOD_HALVINGS = 2 * ROOM_DOUBLINGS
