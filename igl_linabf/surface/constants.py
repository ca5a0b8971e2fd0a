"""Numbers that surfaces and flat maps are held to."""

# Coordinates

# Largest coordinate of a mesh or of pins; the largest one of a mesh is at least its inverse. Beyond, fourth
# powers of lengths overflow or vanish: `clean` scales, all else refuses (tests/test_bad_input.py).
LARGEST_COORDINATE = 1e60
SMALLEST_COORDINATE = 1e-60

# Vertices that faces may refer to where no positions tell how many there are. More would ask for gigabytes
# before any check; fewer refuse large meshes. tests/flattening/test_flattener.py
MOST_VERTICES = 2**31

# Flat maps

# Ratio of a map's largest area scale to its smallest one, up to which double precision is enough. Beyond,
# rounding ends SLIM early, and the outcome advises to cut the mesh
# (tests/flattening/fallbacks/test_attempts.py).
SAFE_AREA_RATIO = 1e12

# The same ratio, beyond which edge lengths differ by all 15 digits of a double. Below, another layout may
# help; above, none does and none is tried (tests/flattening/fallbacks/test_attempts.py).
HOPELESS_AREA_RATIO = 1e30

# Share of the largest area scale that the smallest one counts as, at least: the ratio of a collapsed map is
# its inverse. Less tells nothing more, as all digits differ; more hides that a layout is hopeless
# (tests/flattening/fallbacks/test_attempts.py).
LEAST_AREA_SHARE = 1e-32

# Triangulation of polygons (all of them: tests/charts/atlas/test_polygons.py)

# Corners of a polygon up to which the best of all triangulations is searched, in k^3 steps. Larger ones are
# clipped ear by ear, which is faster and gives worse triangles.
LARGEST_SEARCHED_POLYGON = 200

# Numbers in an array of that search: polygons are searched so many at a time. A smaller array costs more
# calls, a larger one more than 32 MB. No result depends on it.
SEARCH_BATCH = 4_000_000

# Double area of a triangle, over the square of its polygon's longest diagonal, up to which it counts as none.
# Below 1e-15, rounding passes for an area; from 1e-9 on, polygons 1e10 times as long as wide lose theirs.
NEGLIGIBLE_POLYGON_AREA = 1e-12

# Cost of a triangle without area, where others cost their sum of cotangents. With less, it would be preferred
# to thin triangles; with more, sums of costs lose the digits of the others.
COST_WITHOUT_AREA = 1e6
COST_OF_TAKEN_DIAGONAL = 100 * COST_WITHOUT_AREA  # such an edge would have four faces
COST_OF_TURNED_TRIANGLE = 1000 * COST_OF_TAKEN_DIAGONAL  # worse than any number of the two
