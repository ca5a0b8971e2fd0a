"""The loops over triangles, edges and matrices, compiled ahead from `src`: plain arrays in, plain arrays out.

There are two builds of the same source, for every processor and for those of x86-64-v3 (AVX2, since 2013).
"""

from . import _baseline

if _baseline.has_v3():
    from . import _v3 as _built
else:
    _built = _baseline

# connectivity and graphs
above = _built.above
arcs_between = _built.arcs_between
behind_least_cut = _built.behind_least_cut
boundary_loops = _built.boundary_loops
connected_labels = _built.connected_labels
cycles = _built.cycles
entries = _built.entries
fans_around = _built.fans_around
far_apart = _built.far_apart
in_edges = _built.in_edges
in_one_piece = _built.in_one_piece
meeting = _built.meeting
nearest_sources = _built.nearest_sources
nodes_on_paths = _built.nodes_on_paths
opened = _built.opened
shortest_odd_walk = _built.shortest_odd_walk
shortest_pairs = _built.shortest_pairs
spanning_forest = _built.spanning_forest
undirected = _built.undirected
used_vertices = _built.used_vertices
way_of_fewest = _built.way_of_fewest
ways_towards = _built.ways_towards
without_leaves = _built.without_leaves
