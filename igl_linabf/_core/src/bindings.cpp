// The Python module of the core, compiled once for all processors and once for x86-64-v3.
#include "angles/boundary.hpp"
#include "angles/maps.hpp"
#include "angles/reduced_system.hpp"
#include "angles/symmetric.hpp"
#include "cholesky/cholesky.hpp"
#include "graphs/connectivity.hpp"
#include "graphs/seams.hpp"
#include "graphs/shortest_paths.hpp"
#include "isometry/isometric_energy.hpp"
#include "numpy.hpp"
#include "overlaps/common_areas.hpp"
#include "overlaps/overlap_layers.hpp"
#include "overlaps/overlapping.hpp"
#include "overlaps/unfolding.hpp"
#include "packing/bitmap_packing.hpp"
#include "packing/cut_lines.hpp"
#include "packing/rasterize.hpp"
#include "packing/rectangles.hpp"
#include "processor.hpp"

template <class I>
static void analyse(cholesky::Symbolic* self, View<const I> indptr, View<const I> indices, int block) {
    new (self) cholesky::Symbolic(indptr, indices, block);
}

static void bind_cholesky(nb::module_& m) {
    using namespace cholesky;
    using Data = nb::ndarray<const double, nb::c_contig, nb::device::cpu>;
    nb::class_<Factor>(m, "Factor", "A Cholesky factor of a matrix.")
        .def_ro("bad_row", &Factor::bad_row, "Row of the first pivot that is not positive and finite, or -1.")
        .def("solve", [](const Factor& self, Data B) -> nb::object {
            if (B.ndim() < 1 || B.ndim() > 2 || Index(B.shape(0)) != self.rows())
                throw std::invalid_argument("the right-hand sides do not have as many rows as the matrix");
            Array<double> X = without_gil([&] { return self.solve(B.data(), B.ndim() == 2 ? Index(B.shape(1)) : 1); });
            return B.ndim() == 2 ? nb::cast(to_numpy(std::move(X), X.rows, X.columns))
                                 : nb::cast(to_numpy(std::move(X), X.rows));
        }, "B"_a, "Return X such that A X = B, for B of shape (n,) or (n, k).");
    nb::class_<Symbolic>(m, "Symbolic",
                         "The symbolic analysis of a symmetric pattern: order, elimination tree and supernodes.\n\n"
                         "The pattern is a lower triangle in CSC, with the diagonal entry first in each column. If "
                         "`block` is 2, each entry represents a 2 by 2 block.")
        .def("__init__", wrap(&analyse<std::int32_t>, "* * * *"), "indptr"_a, "indices"_a, "block"_a = 1)
        .def("__init__", wrap(&analyse<std::int64_t>, "* * * *"), "indptr"_a, "indices"_a, "block"_a = 1)
        .def_prop_ro("bytes", &Symbolic::bytes, "Memory of a factor, in bytes.")
        .def("factor", [](std::shared_ptr<const Symbolic> self, Data values) {
            if (Index(values.size()) != self->entries)
                throw std::invalid_argument("the number of values is not that of the pattern");
            const View<const double> data{values.data(), Index(values.size())};
            return without_gil([&] { return std::make_unique<Factor>(std::move(self), data); });
        }, "values"_a,
             "Factor a matrix, given by the values of its lower triangle. The values of blocks are those of the upper "
             "triangle, each in row-major order; diagonal blocks are complete.");
}

// Functions on sparse matrices, whose indices are int64 or int32.
template <class I>
static void bind_indexed(nb::module_& m) {
    using namespace angles;
    m.def("laplacian_entries", wrap(&laplacian_entries<I>, "n+1 e 2,e e"), "indptr"_a, "slot"_a, "ends"_a, "weight"_a,
          "Return the entries of the upper triangle of a Laplacian, in the order of `symmetric_pattern`.\n\n"
          "`ends`, (2, #E), are the rows of the end vertices of each edge, or -1 for fixed vertices.");
    m.def("system_blocks", wrap(&system_blocks<I>, "n+1 s e 2,e 2,e 3,m * * 3,m m 3,m"), "indptr"_a, "indices"_a,
          "slot"_a, "ends"_a, "sides"_a, "corner"_a, "row"_a, "wheels"_a, "w"_a, "d"_a, "cot"_a,
          "Return the blocks of S = sum_t M_t P_t M_t^T, (#blocks, 4), in the order of `symmetric_pattern`.\n\n"
          "Diagonal blocks are halved. A block consists of (vertex, vertex), (vertex, wheel), (wheel, vertex) and\n"
          "(wheel, wheel). From row `wheels` on, wheel rows are rows of the identity.");
    m.def("block_product", wrap(&block_product<I>, "n+1 s s,4 2n"), "indptr"_a, "indices"_a, "block"_a, "x"_a,
          "Return (U + U^T) x, where U is a matrix of 2 by 2 blocks, (#blocks, 4), in a CSR pattern.");
    m.def("symmetric_product", wrap(&symmetric_product<I>, "n+1 s s n,2"), "indptr"_a, "indices"_a, "data"_a, "x"_a,
          "Return A x, (n, 2), for a symmetric matrix A, given by its lower triangle in CSC.");
    m.def("block_rows", wrap(&block_rows<I>, "n+1 s n"), "indptr"_a, "indices"_a, "number"_a,
          "Return the start of each selected row, and the ascending columns and the positions of its blocks.\n\n"
          "The position of a block is its index among the blocks of the matrix, or ~index for a transposed block.\n"
          "`number`, (n,), counts the selected rows from 0 in ascending order; it is -1 for all other rows.");
}

static void bind_angles(nb::module_& m) {
    using namespace angles;
    m.def("develop_loops", wrap(&develop_loops, "k+1 n n n"), "start"_a, "turning"_a, "log_ratio"_a, "movable"_a,
          "Return the vertex positions of loops, one loop after another, and the relative gap of each loop.\n\n"
          "Loop i has the vertices start[i] to start[i + 1] - 1. Each vertex has an exterior angle, the logarithm of\n"
          "the ratio of the next to the previous edge length, and a flag whether its angle may change such that the\n"
          "angles of the loop sum to 2 pi. Gaps are closed by the smallest change of lengths.");
    m.def("loop_gaps", wrap(&loop_gaps, "h k+1 n n"), "vertex"_a, "start"_a, "turning"_a, "log_ratio"_a,
          "Return the gaps of loops that turn by -2 pi, relative to their lengths, and the derivatives of the gaps\n"
          "with respect to log_ratio + i turning at the vertices.\n\n"
          "A derivative is the vector from the vertex to the end of the loop minus the mean of these vectors,\n"
          "averaged over all choices of the start vertex.");
    m.def("sum_by_index", wrap(&sum_by_index, "m m n"), "index"_a, "values"_a, "n"_a,
          "Sum the values that have the same index, for each index 0 .. n - 1.");
    m.def("side_products", wrap(&side_products, "v,3 3,m"), "V"_a, "corner"_a,
          "Return twice the areas, the scalar products of the sides at each corner, and bounds of the rounding errors\n"
          "of the double areas.");
    m.def("normals", wrap(&normals, "v,3 3,m"), "V"_a, "corner"_a,
          "Return the unit normals of triangles, (#F, 3), which are zero or arbitrary for degenerate triangles.");
    m.def("dihedrals", wrap(&dihedrals, "v,3 3,m 2,e m,3"), "V"_a, "corner"_a, "sides"_a, "normal"_a,
          "Return the dihedral angle at each edge, negative at concave edges; `sides`, (2, #E), are the half-edges.");
    m.def("lengths", wrap(&lengths, "v,d e,2"), "V"_a, "edges"_a,
          "Return the lengths of edges, given by their end vertices (#E, 2).");
    m.def("cotangents", wrap(&cotangents, "3,m"), "alpha"_a,
          "Return cot alpha, (3, #F), which is infinite for an angle of 0.");
    m.def("rescaled_angles", wrap(&rescaled_angles, "3,m 3,m n"), "corner"_a, "length"_a, "factor"_a,
          "Return the angles, (3, #F), after each side is multiplied by the factor of its opposite vertex.\n\n"
          "Also return a mask of the triangles that violate the triangle inequality; their angles are meaningless.");
    m.def("angle_sums", wrap(&angle_sums, "3,m 3,m 3,m n"), "corner"_a, "alpha"_a, "cot"_a, "n"_a,
          "Return, for each vertex, the sums of its angles and of log sin(gamma) - log sin(beta) (eq. 5 and 10).");
    m.def("constraint_changes", wrap(&constraint_changes, "3,m 3,m 3,m n"), "corner"_a, "cot"_a, "e"_a, "n"_a,
          "Return M e: the changes of the vertex and the wheel constraints, (n,) each, by the errors (3, #F).");
    m.def("errors", wrap(&errors, "3,m 3,m m 3,m n n"), "corner"_a, "w"_a, "d"_a, "cot"_a, "vertex"_a, "wheel"_a,
          "Return P M^T x for multipliers (n,) of vertices: errors (3, #F) that sum to zero in each triangle.");
    m.def("project_errors", wrap(&project_errors, "3,m m 3,m"), "w"_a, "d"_a, "y"_a,
          "Return P y: errors (3, #F) that sum to zero in each triangle.");
    m.def("conformal_errors", wrap(&conformal_errors, "3,m 3,m n n"), "corner"_a, "cot"_a, "vertex"_a, "wheel"_a,
          "Return K M^T x for multipliers (n,) of vertices, where K is the cotangent matrix of each triangle.");
    m.def("limit_step", wrap(&limit_step, "3,m 3,m *"), "alpha"_a, "e"_a, "reach"_a,
          "Scale the errors of each triangle to at most the share `reach` of the step at which an angle vanishes.\n\n"
          "Also return a mask of the triangles in which the full step would make an angle vanish.");
    m.def("pair_weights", wrap(&pair_weights, "3,m m"), "w"_a, "d"_a,
          "Return the pair weight w_i w_j / d, (3, #F), at the corner opposite to corners i and j.\n\n"
          "y^T P y is the sum of pair weight times (y_i - y_j)^2 over the three pairs of corners.");
    m.def("conformal_weights", wrap(&conformal_weights, "3,m m 3,m"), "w"_a, "d"_a, "cot"_a,
          "Return the weights of half-edges, (3, #F), in the Laplacian sum of s K, with s = 2 sqrt(w0 w1 w2 / d).");
    m.def("eigenvalue_disparity", wrap(&eigenvalue_disparity, "3,m m 3,m"), "w"_a, "d"_a, "cot"_a,
          "Return rho + 1 / rho of each triangle, (#F,), where rho is the eigenvalue ratio of P and s K.");
    m.def("edge_sums", wrap(&edge_sums, "3,m 2,e"), "values"_a, "sides"_a,
          "Return the sum of the values, (3, #F), of the half-edges `sides`, (2, #E), of each edge.\n\n"
          "The second half-edge of a boundary edge is -1.");
    m.def("fixed_vertex_terms", wrap(&fixed_vertex_terms, "2,e e,2 e v n"), "ends"_a, "edges"_a, "weight"_a, "z"_a,
          "n"_a,
          "Return the contribution of fixed vertices to L x, (n, 2).\n\n"
          "In each row, it is the sum of weight times z over the edges to fixed vertices; z must be zero at all\n"
          "other vertices.");
    m.def("signed_double_areas", wrap(&signed_double_areas, "v 3,m"), "z"_a, "corner"_a,
          "Return twice the signed area of each face of a flat map (#V,), positive unless flipped or collapsed.");
    m.def("normalize_maps", wrap(&normalize_maps, "v 3,m m k k+1 k+1"), "z"_a, "corner"_a, "double_area"_a, "area"_a,
          "vertex_start"_a, "face_start"_a,
          "Scale each of several concatenated maps to its area, center it, and align its principal axes.\n\n"
          "Map i has the vertices `vertex_start[i]` to `vertex_start[i + 1] - 1` and the faces `face_start[i]` to\n"
          "`face_start[i + 1] - 1`. The longer principal axis becomes the x axis, in the direction for which the\n"
          "third moment is positive. For symmetric maps, the axes are chosen by a rule that is robust to rounding.");
    m.def("triangle_changes", wrap(&triangle_changes, "v,3 v,2 3,m m 3,m"), "V"_a, "uv"_a, "corner"_a, "double_area"_a,
          "dot"_a,
          "Measure the change of each triangle by a flat map (#V, 2) of a `Mesh` with this `double_area` and `dot`.\n\n"
          "Returns the angles in space, and the angles in the map minus those in space, (3, #F) each; twice the\n"
          "signed areas in the map; the larger and the smaller singular value; and the ratios of side lengths,\n"
          "(3, #F).");
    m.def("block_dots", wrap(&block_dots, "k+1 n n"), "start"_a, "a"_a, "b"_a,
          "Return the scalar products of the blocks of two vectors; block k is `start[k]` to `start[k + 1] - 1`.");
    m.def("cg_step", wrap(&cg_step, "k+1 k n n n n"), "start"_a, "rho"_a, "p"_a, "q"_a, "x"_a.noconvert(),
          "r"_a.noconvert(),
          "In each block, add (rho / p . q) p to x and subtract (rho / p . q) q from r, with q = A p; return r . r.\n\n"
          "Blocks with rho = 0 do not change.");
    m.def("update_cg_direction", wrap(&update_cg_direction, "k+1 k k n n"), "start"_a, "rho"_a, "last"_a, "z"_a,
          "p"_a.noconvert(),
          "In each block, update the conjugate gradient direction p to z + (rho / last) p, where `last` is the\n"
          "previous rho, or to z if rho or last is 0.");
    m.def("gather_row_blocks", wrap(&gather_row_blocks, "s,4 e e e"), "block"_a, "column"_a, "place"_a, "of"_a,
          "Return the blocks, (#blocks, 4), of the rows that `block_rows` has selected.\n\n"
          "`of` is the row of each result. `block` contains the stored blocks, in which diagonal blocks are halved.");
    m.def("subtract_rows", wrap(&subtract_rows, "k+1 e e,4 2k r"), "start"_a, "column"_a, "block"_a, "x"_a, "r"_a,
          "Return r - R^T x, (n,), where R consists of the rows selected by `block_rows`; r may be longer.");
    m.def("row_residual", wrap(&row_residual, "k+1 e e,4 k r z"), "start"_a, "column"_a, "block"_a, "of"_a, "r"_a,
          "z"_a,
          "Return r - R z, (2 #rows,), where R consists of the rows `of` of a matrix, and r is restricted to these\n"
          "rows.");
    bind_indexed<Index>(m);  // first, because nanobind converts other integer types to the first overload
    bind_indexed<std::int32_t>(m);
}

// Functions on graphs in CSR; SciPy stores indices as int32 if the graph is small enough.
template <class Int>
static void bind_searches(nb::module_& m) {
    using namespace graphs;
    m.def("nearest_sources", wrap(&nearest_sources<Int>, "n+1 e e s n *"), "indptr"_a, "indices"_a, "length"_a,
        "sources"_a, "open_"_a, "limit"_a,
        R"(Find the nearest source of each node; returns the distance, the predecessor on the path, and that source.

The graph is given in CSR. Nodes that are not open, or farther than `limit`, are not reached: their distance is
infinite, and their predecessor and source are -1. A negative limit counts as 0.)");
    m.def("goal_directed_search", wrap(&goal_directed_search<Int>, "n+1 e e <n n n,3 t,3 * *"), "indptr"_a, "indices"_a,
        "length"_a, "source"_a, "open_"_a, "position"_a, "targets"_a, "share"_a, "limit"_a,
        R"(Return distances from a node, and predecessors, where the paths on to all targets stay within a limit.

Same as `nearest_sources`, but nodes may be omitted if their distance plus a lower bound of the lengths of the paths
to all `targets`, (#T, 3), exceeds the limit. The lower bound of a path from a node at `position`, (n, 3), is `share`
times the distance in space.)");
    m.def("steiner_paths", wrap(&steiner_paths<Int>, "n+1 e e * n *"), "indptr"_a, "indices"_a, "length"_a, "sources"_a,
        "open_"_a, "limit"_a,
        R"(Return the paths to three sets of nodes from their Steiner point, which minimizes the total length.

Returns the nodes of the three paths, one path after another, each from the Steiner point to the first node in the set;
and the start of each path, (4,). There are no paths if the total exceeds the limit. The graph is given in CSR. Paths do
not pass nodes that are not open, except nodes of the set that they lead to.)");
    m.def("choose_distant_nodes", wrap(&choose_distant_nodes<Int>, "n+1 e s * n"), "indptr"_a, "indices"_a, "order"_a,
        "hops"_a, "closed"_a,
        R"(Choose nodes greedily in the given order, skipping nodes within `hops` edges of a chosen one; return a mask.

The graph is given in CSR. Closed nodes are neither chosen nor passed.)");
}

static void bind_graphs(nb::module_& m) {
    using namespace graphs;
    bind_searches<Index>(m);
    bind_searches<std::int32_t>(m);
    m.def("find_edges", wrap(&find_edges, "3,m n"), "corner"_a, "n"_a,
        R"(Find the edges of triangles, (3, #F): ends, (#E, 2), half-edges, (2, #E), and whether they are sound.

Ends and half-edges are those of a `Topology`; the edges are sorted by their lower and higher ends. They are sound if
none has more than two half-edges, or two half-edges of the same direction.)");
    m.def("group_sides", wrap(&group_sides, "h h n"), "tail"_a, "head"_a, "n"_a,
        "Sort half-edges by edge; return the sorted half-edges, and the first position and the number of half-edges\n"
        "of each edge.");
    m.def("used_vertices", wrap(&used_vertices, "m,3 n"), "F"_a, "n"_a,
        "Mark the vertices that valid faces use, and check that all faces have three distinct indices below n.");
    m.def("symmetric_pattern", wrap(&symmetric_pattern, "2,e n"), "ends"_a, "n"_a,
        R"(Build the pattern of symmetric matrices over a graph with edges between rows `ends`, (2, #E).

Returns indptr and indices of the upper triangle in CSR, with the diagonal entry first in each row, and the position of
the entry of each edge, or -1 if the edge does not join two rows.)");
    m.def("shortest_edges", wrap(&shortest_edges, "e,2 e n"), "ends"_a, "length"_a, "n"_a,
        R"(Return the neighbours of each of n nodes in CSR, and the shortest edge to each neighbour; `ends` is (#E, 2).

Columns are ascending. The first of equally short edges is returned; edges from a node to itself are ignored.)");
    m.def("boundary_loops", wrap(&boundary_loops, "h h n"), "tail"_a, "head"_a, "n"_a,
        R"(Chain boundary half-edges into loops; return their vertices, one loop after another, and their sizes.

A loop begins at its lowest vertex, and loops are sorted by their lowest vertices. If two half-edges leave the same
vertex, no loops are returned, and the third array contains the vertices that two half-edges leave.)");
    m.def("cycles", wrap(&cycles, "n"), "following"_a,
        "Return the cycles of a permutation, as lists, in the order of their first elements.");
    m.def("connected_labels", wrap(&connected_labels, "e,2 n"), "edges"_a, "n"_a,
        R"(Return the connected component of each node 0 .. n - 1 of a graph with the given edges, (#E, 2).

Components are numbered from 0, in the order of their first nodes.)");
    m.def("spanning_forest", wrap(&spanning_forest, "e,2 k n"), "pairs"_a, "order"_a, "n"_a,
        R"(Return the edges in `order` that do not close a cycle with earlier edges; `pairs` are their end nodes.

If the order is by weight, this is the minimum spanning forest (Kruskal 1956).)");
    m.def("is_connected", wrap(&is_connected, "2,e m"), "sides"_a, "n_faces"_a,
        "Return True if every face can be reached from face 0 across edges; `sides` is that of a `Topology`.");
    m.def("count_fans", wrap(&count_fans, "3,m 2,e n"), "corner"_a, "sides"_a, "n"_a,
        "Count the fans of each of n vertices, given the corners (3, #F) and the `sides` of a `Topology`.");
    m.def("shortest_odd_walk", wrap(&shortest_odd_walk, "n+1 e e e <n *"), "indptr"_a, "indices"_a, "length"_a,
        "flip"_a, "start"_a, "copies"_a,
        R"(Find the shortest closed walk from a node that crosses each of several curves an odd number of times.

The bits of `flip` are the curves that an edge crosses. The graph is given in CSR. There is a copy of the graph for each
combination of parities: copy c has the nodes from c n on, and is reached after an odd number of crossings of the curves
in the bits of c. The walk is returned from its end, which is in the last copy; if there is no such walk, the result is
the end alone.)");
    m.def("path_nodes", wrap(&path_nodes, "n s"), "before"_a, "ends"_a,
        R"(Return the nodes on the paths from `ends` back to their sources, each once, in the order of the paths.

`before` is the predecessor of each node, and -1 at sources, which are not returned.)");
    m.def("breadth_first_path", wrap(&breadth_first_path, "n+1 e n n"), "indptr"_a, "indices"_a, "sources"_a, "ends"_a,
        R"(Find a path with the fewest edges, and return its nodes from one of `ends` back to one of `sources`.

`ends` and `sources` are masks. The graph is given in CSR. The path is empty if no end can be reached.)");
    m.def("forest_parents", wrap(&forest_parents, "e,2 n"), "pairs"_a, "n"_a,
        R"(Return the parent of each of n nodes of a forest with the given edges, (#E, 2); a root is its own parent.

The root of a tree is its first node.)");
    m.def("prune_leaves", wrap(&prune_leaves, "e,2 n"), "ends"_a, "kept"_a,
        R"(Prune the leaves of a graph with the edges `ends`, (#E, 2), repeatedly; return a mask of the remaining edges.

Nodes in `kept` are never pruned.)");
    m.def("split_arcs", wrap(&split_arcs, "e,2 n"), "ends"_a, "joint"_a,
        R"(Divide the edges of a graph, (#E, 2), into arcs between joints, followed by closed arcs without a joint.

All nodes that do not have exactly two edges must be joints. Returns the edges of all arcs, one arc after another; the
nodes that the arcs pass, including both ends; and the start of the edges of each arc. The nodes of arc k begin k
entries later, because each arc has one more node than edges. Arcs are in the order of their first edges.)");
    m.def("cut_topology", wrap(&cut_topology, "e,2 e,2 s h n m"), "ends"_a, "faces"_a, "seam"_a, "holes"_a, "n"_a,
        "n_faces"_a,
        R"(Analyse the topology of a surface that is cut along a seam, a set of edges of a graph on it.

`ends` and `faces` are the nodes and the faces of each edge, (#E, 2). The first `holes` nodes are holes of the surface,
which belong to the seam. Returns the number of components and of independent cycles of the seam, and the numbers of
faces of the resulting pieces, ascending.)");
    m.def("minimum_cut_side", wrap(&minimum_cut_side, "e,2 e n <n <n"), "ends"_a, "capacity"_a, "n"_a, "source"_a,
        "sink"_a,
        R"(Return a mask (n,) of the nodes on the side of the sink of a minimum cut.

Among several minimum cuts, use the one nearest to the source.

Parameters
----------
ends : (#E, 2) int64
    Edges between different nodes.
capacity : (#E,) int64
    Cost of cutting each edge; below 2^31.
n, source, sink : int)");
}

static void bind_overlaps(nb::module_& m) {
    using namespace overlaps;
    m.attr("DEPTH") = DEPTH;
    m.def("find_overlaps", wrap(&find_overlaps, "v f,3 f k"), "z"_a, "F"_a, "chart"_a, "limit"_a,
          "Return the pairs of faces i < j, (#P, 2), of the same chart that overlap in a map (#V,), sorted.\n\n"
          "If there are more than `limit` pairs, only `limit` + 1 of them are returned.\n\n"
          "Each of the two faces reaches across all sides of the other by more than a millionth of the smaller\n"
          "height, and by more than the rounding error of the corners. Collapsed faces never overlap.");
    m.def("has_overlap", wrap(&has_overlap, "s,3 o,3"), "some"_a, "others"_a,
          "Return True if a triangle of `some`, (#S, 3), overlaps another triangle of `some` or of `others`, (#O, 3).");
    m.def("common_areas", wrap(&common_areas, "v f,3 p,2"), "z"_a, "F"_a, "pairs"_a,
          "Return the area that the two triangles of each pair, (#P, 2), have in common in a map (#V,).");
    m.def("overlap_sheets", wrap(&overlap_sheets, "p p n+1 e k"), "upper"_a, "lower"_a, "begin"_a, "neighbour"_a,
          "most"_a,
          "Return the faces of the two sheets of each of the `most` largest overlaps, and the start of each sheet.\n\n"
          "`upper` and `lower` are the overlapping pairs of faces, in both orders and sorted lexicographically; the\n"
          "adjacent faces of each face are given in CSR. Two pairs are neighbours if they have one face in common and\n"
          "their other faces are adjacent. An overlap is a connected component of pairs together with the mirrored\n"
          "component. If a face is above one face and below another, the sheets are grown from the first pair until\n"
          "they meet. Each sheet is connected, and its faces are ascending.");
    m.def("merge_regions", wrap(&merge_regions, "t,3 t r+1 h,2 h h h h"), "triangle"_a, "depth"_a, "start"_a, "pairs"_a,
          "turn"_a, "shift"_a, "worth"_a, "page"_a,
          "Join regions to charts, hinge by hinge.\n\n"
          "Returns the chart of each region, and the motion from the frame of the region to the plane of the chart.\n"
          "Region r has the counter-clockwise triangles (#T, 3) `start[r]` to `start[r + 1] - 1`. Hinge h joins the\n"
          "charts of the regions `pairs[h]` = (a, b) by the motion z -> `turn[h]` * z + `shift[h]` from the frame of\n"
          "b to that of a, unless the charts would overlap, or the area of the rectangle around both would exceed the\n"
          "areas of the rectangles around each by more than `worth[h]`. A rectangle that is too long for a page of\n"
          "the area `page[h]` counts more. Triangles may reach into each other by the smaller of their `depth`;\n"
          "triangles of negative depth are ignored.");
}

static void bind_packing(nb::module_& m) {
    using namespace packing;
    m.def("rasterize", wrap(&rasterize, "s s s o+1 k k *"), "start"_a, "end"_a, "weight"_a, "sides"_a, "turns"_a,
        "of"_a, "half"_a,
        R"(Rasterize rotated outlines, widened by `half` in all four directions, to blocks of cells.

Outline i has the sides sides[i] to sides[i + 1] - 1, each with a weight. Mask k shows outline of[k],
multiplied by turns[k], in the smallest grid that contains it. of is ascending. If turns[k] is the
opposite of turns[k - 1] for the same outline, the mask is the previous mask rotated by 180 degrees.

Returns the rows and columns of each mask, (#M, 2); the lower left corners, (#M,); the blocks, (#B, 4),
sorted by size within each mask; and the first block of each mask, (#M + 1,).)");
    m.def("place_masks", wrap(&place_masks, "s p c k b k+1"), "side"_a, "most"_a, "spans"_a, "shapes"_a, "blocks"_a,
        "start"_a,
        R"(Place charts on square pages with `side` by `side` cells, each by one of its masks.

Chart i has the masks `spans[i, 0]` to `spans[i, 1] - 1`; `shapes` are their rows and columns. Mask k has
the `blocks` from `start[k]` to `start[k + 1] - 1`: the first row and column, the number of columns and
the number of rows, largest block first.

Returns the mask, page, x and y of each chart, and the width and height of the occupied part of each page.
If a chart does not fit on an empty page or on `most` pages, this chart and all later ones get -1.)");
    m.def("occupied_cells", wrap(&occupied_cells, "s c b k+1"), "side"_a, "places"_a, "blocks"_a, "start"_a,
        "Return a mask of the cells, (#pages, side, side), that the charts placed by `place_masks` occupy.");
    m.def("pack_shelves", wrap(&pack_shelves, "r,2 s,s"), "sizes"_a, "taken"_a,
        R"(Place rectangles on shelves of a page, and return the lower left corners (#P, 2) of those that fit.

A shelf is as high as its first rectangle, and continues behind occupied cells.

Parameters
----------
sizes : (#R, 2) float64
    Widths and heights in cells of the page, highest rectangle first.
taken : (side, side) bool
    Occupied cells.)");
    m.def("min_rectangle_rotations", wrap(&min_rectangle_rotations, "p g+1"), "z"_a, "start"_a,
        R"(Return, for each group of points, the rotation that minimizes its axis-aligned bounding rectangle.

Parameters
----------
z : (#P,) complex128
start : (#G + 1,) int64
    Group i has the points start[i] to start[i + 1] - 1.

Returns
-------
turns : (#G,) complex128
    Unit complex numbers; 1 for collinear points.)");
    m.def("evaluate_cut_lines", wrap(&evaluate_cut_lines, "p,2 e,2 e p l,2 l 2,4d"), "points"_a, "ends"_a, "length"_a,
        "outer"_a, "normal"_a, "offset"_a, "outwards"_a,
        R"(Evaluate lines that divide a graph in the plane by cutting the edges that they cross.

Parameters
----------
points : (#P, 2) float64
ends : (#E, 2) int64
length : (#E,) float64
    Cost of cutting each edge.
outer : (#P,) bool
    Points that may be on the convex hull of a part, in addition to the ends of cut edges.
normal : (#L, 2) float64
offset : (#L,) float64
    The points beyond line k have a scalar product with its normal that exceeds its offset.
outwards : (2, 4 #D) float64
    Unit vectors at equal angles, beginning with (1, 0).

Returns
-------
hulls : (#L,) float64
    Total area of the convex hulls of the extreme points, in the directions `outwards`, of the connected parts.
widest : (#L,) float64
    Longest diagonal of an axis-aligned bounding rectangle of a part.
cut : (#L,) float64
    Total length of the cut edges.)");
}

static void bind_isometry(nb::module_& m) {
    using namespace isometry;
    m.def("isometric_energy", wrap(&isometric_energy, "3,m 3,m m v *"), "corner"_a, "gradient"_a, "share"_a, "z"_a,
          "weight"_a,
          "Return the isometric energy of each triangle times its weight in `share`.\n\n"
          "The energy of flipped and collapsed triangles is infinite.\n\n"
          "The map of a triangle is w -> p w + q conj(w), where p is the sum of gradient z over the corners, and q is\n"
          "the sum of conj(gradient) z.");
    m.def("isometric_derivatives", wrap(&isometric_derivatives, "3,m 3,m m v *"), "corner"_a, "gradient"_a, "share"_a,
          "z"_a, "weight"_a,
          "Return the gradient of the energy, (6, #F), and rows, (24, #F), whose sum of row row^T is the convexified\n"
          "Hessian.\n\n"
          "Each triangle has four rows, one after another, each by x of the corners and then by y.");
    m.def("sum_outer_products", wrap(&sum_outer_products, "6r,m 3,m 3,m n"), "rows"_a, "own"_a, "across"_a, "entries"_a,
          "Assemble the blocks, (entries, 4), of the sum of row row^T over triangles; a row has six values.\n\n"
          "The block of corner k is added to entry own[k], and the block of the side opposite to corner k to entry\n"
          "across[k], or transposed to entry ~across[k].");
    m.def("collapse_lengths", wrap(&collapse_lengths, "3,m 3,m v v"), "corner"_a, "gradient"_a, "z"_a, "direction"_a,
          "Return the step length along `direction` at which each triangle collapses, or infinity if never.");
}

NB_MODULE(MODULE, m) {
    #ifdef CHECKED
    m.attr("CHECKED") = true;
#else
    m.attr("CHECKED") = false;
#endif
    m.def("has_v3", &has_v3, "Return True if this processor supports the build for x86-64-v3.");
    bind_cholesky(m);
    bind_angles(m);
    bind_graphs(m);
    bind_isometry(m);
    bind_overlaps(m);
    bind_packing(m);
}
