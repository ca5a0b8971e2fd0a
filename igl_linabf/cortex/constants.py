"""The constants of flat cortices. Lengths on spheres are in radians; a hemisphere is about 100 mm to one."""

# --- templates ---

# Depth from which what a template leaves out is its medial wall, and not a cut. Less takes wide cuts for
# walls; more finds no wall. The wall is 0.5 deep, cuts 0.04. tests/cortex/test_templates.py
WALL_DEPTH = 0.09

# Length from which a branch of what is left out is a cut. Less takes the roughness of the wall's outline for
# cuts, which is 0.08 long; more loses short cuts, of which the shortest is 0.4 long.
# tests/cortex/test_templates.py
SHORTEST_CUT = 0.12

# Price of an edge on the rim of a cut, in lengths of one within: a cut runs along the middle. At 1 it runs
# along the rim; more changes nothing. tests/cortex/test_templates.py
RIM_PRICE = 2.0

# --- transfer ---

# Barycentric weight of vertices within the wall from which a place is in it. Less takes vertices on the rim
# by rounding; more makes the wall smaller by that share of an edge. tests/cortex/test_transfer.py
RIM_WEIGHT = 1e-6

# Points along a template's cut for each edge length of the subject. With fewer, paths are drawn to the points
# and away from the line between them; more cost time. tests/cortex/test_transfer.py
POINTS_AN_EDGE = 2

# Distance from a template's line, radians, beyond which its path does not go. Less finds no path to a medial
# wall of the subject's own that is smaller; more takes longer. tests/cortex/test_flat_hemispheres.py
LARGEST_DETOUR = 0.2

# Share of a hemisphere's vertices from which a piece between cuts and medial wall is worth a warning. Below,
# crumbs beside a cut are counted among what it takes. tests/cortex/test_flat_hemispheres.py
CRUMBS_SHARE = 0.005

# Vertices from which the error of distances is measured. From fewer it is off by more than 0.003; more take
# longer, 2 ms each. tests/cortex/test_flat_hemispheres.py
SOURCES = 500

# --- found cuts ---

# What seams of found cuts may cost, as `trade` of `find_seams`, one after another until the map is good
# enough. A finer ladder takes longer; a coarser one cuts more than it must. tests/cortex/test_found_cuts.py
TRADES = (1.0, 3.0, 10.0, 30.0, 100.0)

# Distance error that found cuts have to reach where none is asked for: the experts' five cuts leave 0.13 of
# fsaverage5. Less cuts more; more leaves more error. tests/cortex/test_found_cuts.py
MAX_DISTANCE_ERROR = 0.15

# --- pictures ---

# Pixels along a side of a panel. Fewer hide small areas; more make large files.
# tests/cortex/test_subject_files.py
PANEL_PIXELS = 900

# Logarithm of the change of area at which the colours end: a factor of two. Less saturates more of the map;
# more shows less. tests/cortex/test_subject_files.py
LARGEST_LOG_AREA = 0.7

# Millimetres over which curvature is smoothed to be drawn: less shows the mesh, more blurs gyri.
# tests/cortex/test_subject_files.py
SMOOTHING = 2.0
