"""The constants of the search for seams. Costs are in units of L2 stretch."""

# ---- What a seam may cost

# Length of a seam, over the square root of the area, that lowering the L2 stretch by 1 is worth. Less gives
# short seams, more little stretch. tests/charts/seams/test_search.py: longer seams for less stretch.
TRADE = 6.0

# Factor of the trade on clusters: a seam gets so much shorter when it is pulled tight. Less grows too few
# branches, more too many. tests/charts/cut_graphs/test_clusters.py: seams of clusters cost what others
# cost.
TIGHTENING = 1.6

# Cost by which a symmetric seam may be dearer. Less cuts alike bodies unlike; more takes bad seams.
# tests/charts/features/test_visibility.py: a symmetric body is cut alike on both sides.
WORTH_OF_SYMMETRY = 0.05

# Cost by which a seam in valleys may be dearer. Less leaves seams in the open; more lets them wander.
# tests/charts/features/test_visibility.py: valleys attract seams.
WORTH_OF_VALLEYS = 0.01

# ---- Branches

# Branches on a component, at most. Fewer leave limbs of large meshes shrunk; more take longer where the
# trade is large. tests/charts/seams/test_search.py: longer seams for less stretch.
MOST_BRANCHES = 100

# Branches in a row that do not pay, before no more are tried. Fewer miss pairs that pay together; more take
# longer. benchmarks/unwrap.py prints stretch and length.
MOST_IN_VAIN = 3

# ---- Many bodies at once

# Faces of a component up to which its seam is found together with others. Fewer take longer; more leave
# seams unshortened. tests/flattening/test_many_meshes.py: seams of many small bodies cost what each alone
# costs.
SMALL_BODY = 100

# Components from which on small ones are done together. Fewer lose the better search; more take longer.
# tests/flattening/test_many_meshes.py
FEW_BODIES = 8

# Faces of a smooth component up to which the same is done among `MANY_BODIES`. Fewer take longer; more
# leave long seams. benchmarks/many.py prints the time.
MEDIUM_BODY = 2_000

# Components from which on these are done together. Fewer lose the better search; more take longer.
# benchmarks/many.py prints the time.
MANY_BODIES = 100

# Share of its area that lies flat, below which a component is smooth: it needs no nets, only branches. Less
# takes longer; more misses nets of boxes. benchmarks/many.py prints the time.
SMOOTH_BODY = 0.1

# ---- Mirror planes

# Distance of a vertex from its mirror image, at most, over the square root of the area; and gap between
# moments of inertia. Less misses rounded bodies; more mirrors others.
# tests/charts/features/test_visibility.py: symmetric.
MIRROR_DISTANCE = 1e-3

# Share of the edges whose mirror image is an edge, at least; diagonals may lie the other way. Less mirrors
# other meshes; more misses such diagonals. benchmarks/constants.py charts.seams
MIRROR_EDGES = 0.9

# Length of a path in the mirror plane, over that of the shortest one, up to which it is taken. Less leaves
# the plane; more makes detours. benchmarks/constants.py charts.seams
MIRROR_DETOUR = 1.5

# Factor of the length of edges in the mirror plane. Less draws seams around a body; more lets them run
# beside the plane. tests/charts/features/test_visibility.py: a symmetric body is cut alike on both sides.
MIRROR_PLANE_PRICE = 0.7
