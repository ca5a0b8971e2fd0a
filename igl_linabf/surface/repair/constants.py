"""Numbers of the repair of triangles; tests/surface/repair and `tests/nasty_meshes.py` have the shapes."""

# What is repaired

# Largest coordinate of a mesh that is not scaled; the smallest is its inverse. Beyond, a power of two scales
# it, since eighth powers of lengths would overflow ("coordinates of 1e200" of tests/nasty_meshes.py).
LARGEST_USUAL_COORDINATE = 1e30
SMALLEST_USUAL_COORDINATE = 1e-30

# Largest coordinate with which vertices are welded by a distance. Beyond, squares of distances overflow; with
# less, meshes are refused that could be welded (test_cleaning.py, weld).
LARGEST_WELDED_COORDINATE = 1e150

# Share of its area that a flat piece loses by projection: its normals differ by a tenth of a degree. With
# less, sides whose corners are rounded are not flat; with more, curved panels are welded (test_cleaning.py,
# flat sides).
FLATNESS = 1e-6

# Sheets

# Faces at an edge up to which all their pairs are compared. Around an edge of more, all faces are taken
# apart; at 5, that parts the "eight pages of a book" (test_cleaning.py, best pair).
MOST_FACES_PAIRED = 500

# Decimals of the cost 1 + cos of joining two faces: 0 flat, 1 at a right angle, 2 folded. With 16, rounding
# would choose among equal pairs; with 2, unequal ones are equal (test_cleaning.py, best pair).
JOIN_COST_DECIMALS = 6

# Added where nothing else joins the two faces' patches. Below 1, "two cubes at an edge" are joined there;
# from 2 on, a fold within a patch comes before a flat continuation in another one (test_cleaning.py, nasty
# meshes).
COST_OF_OTHER_PATCH = 1.05

# Added where a patch becomes one-sided. Below 2, that comes before a fold that keeps it two-sided; more than
# this changes no order within a patch (test_cleaning.py, best pair).
COST_OF_ONE_SIDEDNESS = 3.0

# Faces without area

# Length of a side, over the size of its face's coordinates, up to which it collapses in a face without area.
# Below 1e-15, no side is so short; a longer one belongs to a cap, which is opened (test_slivers.py, needles).
COLLAPSED_LENGTH = 1e-9

# Multiple of the area that rounding can make, up to which a face with such a side collapses. At 1, areas that
# are mostly rounding stay; with more, needles vanish that can be flattened (test_slivers.py, needles).
ROUNDING_MARGIN = 16.0

# How far the arc of opened caps rises, over its chord and over the shortest side of the caps: the lower of
# both. With less, angles are nearer to 180 degrees; more can be seen ("t junctions filled with caps",
# test_cleaning.py).
ARC_HEIGHT = 0.02
ARC_HEIGHT_OF_SHORTEST_SIDE = 0.1

# Where an arc does not open a face, how far its vertex moves at first, over the face's shortest side; then
# twice as far, up to the whole side. Less takes more rounds; more can be seen (test_cleaning.py, random
# damage).
FIRST_SHAKE = 1e-4
