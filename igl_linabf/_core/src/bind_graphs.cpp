// Connectivity of meshes, and graphs on them.
#include <nanobind/stl/array.h>

#include "connectivity.hpp"
#include "numpy.hpp"
#include "seams.hpp"
#include "shortest_paths.hpp"

using namespace graphs;

// What functions take, as it comes from Python.
template <class T>
struct From {
    using Type = T;
};
template <class T>
struct From<View<T>> {
    using Type = In1<T>;
};
template <class T>
struct From<Matrix<T>> {
    using Type = In2<T>;
};
template <class T, std::size_t N>
struct From<std::array<View<T>, N>> {
    using Type = std::array<In1<T>, N>;
};

template <class T>
T taken(T number) {
    return number;
}
template <class T>
View<T> taken(const In1<T>& a) {
    return view(a);
}
template <class T>
Matrix<T> taken(const In2<T>& a) {
    return matrix(a);
}
template <class T>
std::array<View<T>, 3> taken(const std::array<In1<T>, 3>& a) {
    return {view(a[0]), view(a[1]), view(a[2])};
}

// What they return, as it goes to Python.
static bool given(bool answer) { return answer; }
static std::vector<std::vector<Index>> given(std::vector<std::vector<Index>>&& lists) { return std::move(lists); }
template <class T>
Out1<T> given(Array<T>&& a) {
    return out(std::move(a));
}
template <class T>
Out1<T> given(std::vector<T>&& v) {
    return out(std::move(v));
}
template <class... Arrays>
nb::tuple together(Arrays&... arrays) {
    return nb::make_tuple(given(std::move(arrays))...);
}
static auto given(Edges&& a) { return nb::make_tuple(out2(std::move(a.ends)), out2(std::move(a.sides)), a.sound); }
static auto given(InEdges&& a) { return together(a.order, a.begin, a.count); }
static auto given(Used&& a) { return together(a.vertices, a.sound); }
static auto given(Entries&& a) { return together(a.indptr, a.indices, a.slot); }
static auto given(Neighbours&& a) { return together(a.indptr, a.indices, a.edge); }
static auto given(Loops&& a) { return together(a.vertices, a.sizes, a.twice); }
static auto given(Paths&& a) { return together(a.distance, a.before, a.source); }
static auto given(Search&& a) { return together(a.distance, a.before); }
static auto given(Ways&& a) { return together(a.nodes, a.start); }
static auto given(Arcs&& a) { return together(a.edges, a.nodes, a.start); }
static auto given(Opened&& a) { return nb::make_tuple(a.number, a.cycles, out(std::move(a.sizes))); }

// Bind a function on views, without Python's lock while it runs.
template <class Result, class... Taken, class... Extra>
void def(nb::module_& m, const char* name, Result (*function)(Taken...), const Extra&... extra) {
    m.def(
        name,
        [function](typename From<Taken>::Type... args) {
            return given(unlocked([&] { return function(taken(args)...); }));
        },
        extra...);
}

// The loops over graphs in CSR, whose indices SciPy has as int32 where these do.
template <class Int>
static void bind_searches(nb::module_& m) {
    def(m, "nearest_sources", &nearest_sources<Int>, "indptr"_a, "indices"_a, "length"_a, "sources"_a, "open_"_a,
        "limit"_a,
        R"(The distance of each node to the nearest source, the node before it on the path, and that source.

The graph is given as in CSR. Nodes that are not open are not reached, nor what is farther than `limit`: the
distance is infinite there, and the nodes are -1. A limit below 0 is one of 0.)");
    def(m, "ways_towards", &ways_towards<Int>, "indptr"_a, "indices"_a, "length"_a, "source"_a, "open_"_a,
        "position"_a, "targets"_a, "share"_a, "limit"_a,
        R"(The distances from a node, and the nodes before, where all ways on to the targets stay within a limit.

As in `nearest_sources`; what is farther may be left out. A way from a node, at `position` (n, 3), to each of the
`targets`, (#T, 3), is at least a `share` of the distance in space.)");
    def(m, "meeting", &meeting<Int>, "indptr"_a, "indices"_a, "length"_a, "sources"_a, "open_"_a, "limit"_a,
        R"(The ways to three sets of nodes from the node where they are shortest in total.

The nodes of the three ways, one after the other, each from there to the first one in the set; and where each way
begins, (4,). There are none if the total is over the limit. The graph is given as in CSR; nodes that are not open are
not passed, but those of a set by the way to it.)");
    def(m, "far_apart", &far_apart<Int>, "indptr"_a, "indices"_a, "order"_a, "hops"_a, "closed"_a,
        R"(A mask of the nodes that one takes in an order, leaving out those `hops` edges or less from taken ones.

The graph is given as in CSR. Closed nodes are neither taken nor passed.)");
}

void bind_graphs(nb::module_& m) {
    bind_searches<Index>(m);
    bind_searches<std::int32_t>(m);
    def(m, "undirected", &undirected, "corner"_a, "n"_a,
        R"(The edges of triangles, (3, #F): their ends, (#E, 2), sides, (2, #E), and whether they are sound.

Ends and sides are as in `Topology`, the edges sorted by their lower and higher ends. They are sound where none has
more than two sides, or two that run the same way.)");
    def(m, "in_edges", &in_edges, "tail"_a, "head"_a, "n"_a,
        "Sides in the order of their edges, by vertices below n; where each edge begins, and how many it has.");
    def(m, "used_vertices", &used_vertices, "F"_a, "n"_a,
        "Which of n vertices sound faces have, and whether all are: indices in range, none of them twice.");
    def(m, "entries", &entries, "ends"_a, "n"_a,
        R"(The upper triangle of symmetric matrices over a graph of n rows; its edges join rows `ends`, (2, #E).

Returns indptr and indices as in CSR, the diagonal first in each row, and each edge's place among the entries; -1
where it joins a row to itself, or to none.)");
    def(m, "shortest_pairs", &shortest_pairs, "ends"_a, "length"_a, "n"_a,
        R"(The neighbours of each of n nodes, and the shortest edge to each, as in CSR; `ends` are (#E, 2).

Columns ascend. Of equally short edges it is the first one; edges from a node to itself are left out.)");
    def(m, "boundary_loops", &boundary_loops, "tail"_a, "head"_a, "n"_a,
        R"(Boundary half-edges chained into loops: their vertices one loop after the other, and their sizes.

A loop begins at its first vertex, and loops come in the order of these. There are none if two edges leave a vertex;
the third array has such vertices.)");
    def(m, "cycles", &cycles, "following"_a,
        "The cycles of a permutation, as lists, in the order of their first elements.");
    def(m, "connected_labels", &connected_labels, "edges"_a, "n"_a,
        R"(The component of each of the nodes 0 .. n - 1 of a graph with these edges, (#E, 2).

Components are numbered from 0, in the order of their first nodes.)");
    def(m, "spanning_forest", &spanning_forest, "pairs"_a, "order"_a, "n"_a,
        R"(Of the edges `order`, by their pairs of n nodes, those that close no cycle with earlier ones.

If the order is by weight, this is the minimum spanning forest (Kruskal 1956).)");
    def(m, "in_one_piece", &in_one_piece, "sides"_a, "n_faces"_a,
        "Whether every face can be reached from face 0 across edges; `sides` as in `Topology`.");
    def(m, "fans_around", &fans_around, "corner"_a, "sides"_a, "n"_a,
        "How many fans each of n vertices has, by the corners (3, #F) and the sides of edges of a `Topology`.");
    def(m, "shortest_odd_walk", &shortest_odd_walk, "indptr"_a, "indices"_a, "length"_a, "flip"_a, "start"_a,
        "copies"_a,
        R"(The shortest closed walk from a node that crosses each of some ways an odd number of times.

Bits of `flip` tell which ways an edge crosses; the graph is given as in CSR. There is a copy of it for each
combination of bits: copy c, of the nodes from c n on, is reached over the ways of c's bits. The walk is given from its
end, which is in the last copy; that alone if there is no such walk.)");
    def(m, "nodes_on_paths", &nodes_on_paths, "before"_a, "ends"_a,
        R"(The nodes that lead from some ends to their sources, each once, in the order of the paths.

`before` is the node before each one on its path, and -1 at sources, which are left out.)");
    def(m, "way_of_fewest", &way_of_fewest, "indptr"_a, "indices"_a, "sources"_a, "ends"_a,
        R"(The nodes of a way of the fewest steps, from one of the `ends` back to one of the sources, both masks.

The graph is given as in CSR. There are none if no end can be reached.)");
    def(m, "above", &above, "pairs"_a, "n"_a,
        R"(The node above each of n nodes of a forest with these edges, (#E, 2); that of a root is itself.

The root of a tree is its first node.)");
    def(m, "without_leaves", &without_leaves, "ends"_a, "kept"_a,
        R"(The edges of a graph, by their ends (#E, 2), that are left when those at leaves are dropped in turn.

Leaves that are to be kept are none.)");
    def(m, "arcs_between", &arcs_between, "ends"_a, "joint"_a,
        R"(The edges of a graph, by their ends (#E, 2), in rows from joint to joint; then closed rows without any.

All nodes without exactly two edges have to be joints. Returns the edges of all arcs in their order, the nodes that
these pass, from the first to the last, and where the edges of each arc begin. The nodes of arc k begin k later, as it
has one more. Arcs begin in the order of edges.)");
    def(m, "opened", &opened, "ends"_a, "faces"_a, "seam"_a, "holes"_a, "n"_a, "n_faces"_a,
        R"(What a seam, edges of a graph on a surface, opens: its components and cycles, and the pieces.

`ends` and `faces` are the nodes and the faces of each edge, (#E, 2); the first nodes, the holes, are on the seam. The
pieces are given by their numbers of faces, ascending.)");
    def(m, "behind_least_cut", &behind_least_cut, "ends"_a, "capacity"_a, "n"_a, "source"_a, "sink"_a,
        R"(The nodes (n,) behind the least cut between two nodes; of several, the one nearest to the source.

Parameters
----------
ends : (#E, 2) int64
    Edges between different nodes.
capacity : (#E,) int64
    What it costs to cut each; below 2^31.
n, source, sink : int)");
}
