// The Python module, built once for every processor and once for those with AVX2: what it binds, unit by unit.
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
#include "overlaps/overlap_layers.hpp"
#include "overlaps/overlapping.hpp"
#include "overlaps/unfolding.hpp"
#include "packing/bitmap_packing.hpp"
#include "packing/cut_lines.hpp"
#include "packing/rasterize.hpp"
#include "packing/rectangles.hpp"

#if defined(_MSC_VER) && defined(_M_X64)
#include <intrin.h>
#endif

template <class I>
static void analyse(cholesky::Symbolic* self, View<const I> indptr, View<const I> indices, int block) {
    new (self) cholesky::Symbolic(indptr, indices, block);
}

static void bind_cholesky(nb::module_& m) {
    using namespace cholesky;
    using Data = nb::ndarray<const double, nb::c_contig, nb::device::cpu>;
    nb::class_<Factor>(m, "Factor", "A matrix that can be solved with.")
        .def_ro("bad_row", &Factor::bad_row, "Row of the first pivot that is not positive and finite; -1 if none is.")
        .def("solve", [](const Factor& self, Data B) -> nb::object {
            if (B.ndim() < 1 || B.ndim() > 2 || Index(B.shape(0)) != self.rows())
                throw std::invalid_argument("the right-hand sides have another number of rows than the matrix");
            Array<double> X = unlocked([&] { return self.solve(B.data(), B.ndim() == 2 ? Index(B.shape(1)) : 1); });
            return B.ndim() == 2 ? nb::cast(owned(std::move(X), X.rows, X.columns))
                                 : nb::cast(owned(std::move(X), X.rows));
        }, "B"_a, "X of A X = B, for (n,) or (n, k).");
    nb::class_<Symbolic>(m, "Symbolic",
                         "What is known of a symmetric pattern before it has values: order, tree and supernodes.\n\n"
                         "Given by its lower triangle in CSC, the diagonal first in each column. With `block` 2, each "
                         "entry is a 2 by 2 block.")
        .def("__init__", bound(&analyse<std::int32_t>), "indptr"_a, "indices"_a, "block"_a = 1)
        .def("__init__", bound(&analyse<std::int64_t>), "indptr"_a, "indices"_a, "block"_a = 1)
        .def_prop_ro("bytes", &Symbolic::bytes, "What a factor takes.")
        .def("factor", [](const Symbolic& self, Data values) {
            if (Index(values.size()) != self.entries)
                throw std::invalid_argument("values are not those of the pattern");
            return unlocked([&] { return new Factor(self, {values.data(), Index(values.size())}); });
        }, "values"_a, nb::keep_alive<0, 1>(),
             "Factor a matrix, given by the values of the lower triangle; of blocks, by those of the upper one by "
             "rows, whole on the diagonal.");
}

// The loops over sparse matrices, whose indices are int64 or int32.
template <class I>
static void bind_indexed(nb::module_& m) {
    using namespace angles;
    m.def("laplacian_entries", bound(&laplacian_entries<I>), "indptr"_a, "slot"_a, "ends"_a, "weight"_a,
          "The entries, in the places of `entries`, of the Laplacian with `weight` at the edges between rows `ends`.");
    m.def("system_blocks", bound(&system_blocks<I>), "indptr"_a, "indices"_a, "slot"_a, "ends"_a, "sides"_a, "corner"_a,
          "row"_a, "wheels"_a, "w"_a, "d"_a, "cot"_a,
          "The blocks of S = sum_t M_t P_t M_t^T, (#blocks, 4), in the places of `entries`; half of those on the\n"
          "diagonal.\n\n"
          "A block holds (vertex, vertex), (vertex, wheel), (wheel, vertex) and (wheel, wheel). From row `wheels`\n"
          "on, the wheel rows are those of the identity.");
    m.def("block_product", bound(&block_product<I>), "indptr"_a, "indices"_a, "block"_a, "x"_a,
          "(U + U^T) x, U of 2 by 2 blocks: `block`, (#blocks, 4), at rows and columns as in CSR.");
    m.def("product_with_pairs", bound(&product_with_pairs<I>), "indptr"_a, "indices"_a, "data"_a, "x"_a,
          "A x of a symmetric matrix, by its lower triangle in CSC, and two columns x, (n, 2).");
    m.def("products_of_entries", bound(&products_of_entries<I>), "indptr"_a, "indices"_a, "block"_a, "C"_a, "first"_a,
          "last"_a, "The rows from `first` up to `last` of U_e C, side by side for the entries e = 0 .. 3 of blocks.");
    m.def("block_rows", bound(&block_rows<I>), "indptr"_a, "indices"_a, "number"_a,
          "Start of each row and columns of its blocks, ascending, and their places; ~place of transposed ones.\n\n"
          "`number`, (n,), has the place of a row among the chosen ones, in ascending order, or -1.");
}

static void bind_angles(nb::module_& m) {
    using namespace angles;
    m.def("developed_loops", bound(&developed_loops), "start"_a, "turning"_a, "log_ratio"_a, "movable"_a,
          "Positions of the vertices of loops, one after the other, and the loops' relative gaps.\n\n"
          "Loop i has the vertices start[i] to start[i + 1]; at each an exterior angle, the logarithm of the next\n"
          "edge's length over the last one's, and whether the angle may change so that those of the loop sum to 2 pi.\n"
          "Gaps are closed by the smallest change of lengths.");
    m.def("lay_out_loops", bound(&lay_out_loops), "vertex"_a, "start"_a, "turning"_a, "log_ratio"_a,
          "The gaps of loops that turn by -2 pi, in units of their lengths, and their derivatives by log_ratio + i\n"
          "turning at the vertices: the vector to the loop's end, minus its mean, over all vertices as the loop's\n"
          "start.");
    m.def("sum_by", bound(&sum_by), "index"_a, "values"_a, "n"_a, "Sum `values` over equal `index`, 0 .. n - 1.");
    m.def("products", bound(&products), "V"_a, "corner"_a,
          "Twice the areas, the scalar products, and the least double area that rounding does not make.");
    m.def("normals", bound(&normals), "V"_a, "corner"_a,
          "Unit normals of triangles, (#F, 3); zero, or what rounding makes of it, where there is no area.");
    m.def("dihedrals", bound(&dihedrals), "V"_a, "corner"_a, "sides"_a, "normal"_a,
          "Angle between the normals at edges, of sides (2, #E); negative where the surface is concave.");
    m.def("lengths", bound(&lengths), "V"_a, "edges"_a, "Of edges, (#E, 2).");
    m.def("cotangents", bound(&cotangents), "alpha"_a,
          "cot alpha, (3, #F); infinite at an angle of 0, as in a collapsed triangle.");
    m.def("rescaled", bound(&rescaled), "corner"_a, "length"_a, "factor"_a,
          "Angles (3, #F) of triangles whose sides, (3, #F), are multiplied by the factor of the vertex opposite.\n\n"
          "Also tells which triangles cannot have such sides; their angles mean nothing.");
    m.def("angle_sums", bound(&angle_sums), "corner"_a, "alpha"_a, "cot"_a, "n"_a,
          "At each vertex the sum of its angles, and of log sin(gamma) - log sin(beta) (eq. 5 and 10).");
    m.def("row_sums", bound(&row_sums), "corner"_a, "cot"_a, "e"_a, "n"_a,
          "M e: what errors (3, #F) change the vertex and the wheel constraint of each vertex by, (n,) each.");
    m.def("errors", bound(&errors), "corner"_a, "w"_a, "d"_a, "cot"_a, "vertex"_a, "wheel"_a,
          "P M^T x of multipliers (n,) of single vertices: angles (3, #F) that sum to zero in each triangle.");
    m.def("projected", bound(&projected), "w"_a, "d"_a, "y"_a,
          "P y: (3, #F) angles that sum to zero in each triangle.");
    m.def("conformal_errors", bound(&conformal_errors), "corner"_a, "cot"_a, "vertex"_a, "wheel"_a,
          "K M^T x of multipliers (n,) of single vertices, K the cotangent matrices: `errors` in that metric.");
    m.def("conformally", bound(&conformally), "cot"_a, "y"_a, "K y: (3, #F) angles that sum to zero in each triangle.");
    m.def("limit_step", bound(&limit_step), "alpha"_a, "e"_a, "reach"_a,
          "The errors, up to a share `reach` of the way to a vanishing angle; and where an angle would vanish.");
    m.def("pair_weights", bound(&pair_weights), "w"_a, "d"_a,
          "w_i w_j / d, (3, #F), k opposite to i and j: y^T P y sums this times (y_i - y_j)^2 over pairs.");
    m.def("conformal_weights", bound(&conformal_weights), "w"_a, "d"_a, "cot"_a,
          "What each half-edge gives to the Laplacian sum of s K, (3, #F); s = 2 sqrt(w0 w1 w2 / d).");
    m.def("disparity", bound(&disparity), "w"_a, "d"_a, "cot"_a,
          "rho + 1 / rho of each triangle, rho the ratio of the eigenvalues of P and s K in it, (#F,).");
    m.def("at_edges", bound(&at_edges), "values"_a, "sides"_a,
          "Sum values of half-edges, (3, #F), over the two sides of each edge, (2, #E), -1 for a missing one.");
    m.def("pulled", bound(&pulled), "ends"_a, "edges"_a, "weight"_a, "z"_a, "n"_a,
          "What fixed vertices add to L x: sum of weight z over the edges to them, (n, 2); z is zero at others.");
    m.def("signed_double_areas", bound(&signed_double_areas), "z"_a, "corner"_a,
          "Twice the signed area of each face of a flat map (#V,); positive where it is not flipped.");
    m.def("centred", bound(&centred), "z"_a, "corner"_a, "double_area"_a, "area"_a, "vertex_start"_a, "face_start"_a,
          "Maps side by side, each scaled to its area, its centroid at 0 and its principal axes along x and y.\n\n"
          "Map i has the vertices `vertex_start[i]` up to `vertex_start[i + 1]`, and such faces. The longer axis\n"
          "is x; of its two directions the one that gives a positive third moment. A symmetric map, of which\n"
          "rounding would choose the axes or a direction, is turned by a rule that does not depend on rounding.");
    m.def("changes", bound(&changes), "V"_a, "uv"_a, "corner"_a, "double_area"_a, "dot"_a,
          "What a flat map (#V, 2) does to each triangle; `double_area` and `dot` as in a `Mesh`.\n\n"
          "The angles in space, and what they are more in the map, (3, #F) each; twice the signed areas in the\n"
          "map; the larger and the smaller singular value; the ratios of the lengths of sides, (3, #F).");
    m.def("developed", bound(&developed), "z"_a, "known"_a, "start"_a, "twin"_a, "corner"_a, "cot"_a,
          "The vertices that are not `known` placed triangle after triangle breadth-first, and the misfit.\n\n"
          "It begins at the half-edges `start`, k #F + t opposite to corner k of triangle t, whose ends are\n"
          "known. `twin` is the half-edge on the other side of each, -1 at the boundary. Where all corners of a\n"
          "triangle lay already, the misfit is how far one is from where it would be placed, over the shortest\n"
          "side: the largest.");
    m.def("block_dots", bound(&block_dots), "start"_a, "a"_a, "b"_a,
          "Scalar products of the blocks of two vectors; block k is `start[k]` to `start[k + 1]`, or empty.");
    m.def("block_step", bound(&block_step), "start"_a, "rho"_a, "p"_a, "q"_a, "x"_a.noconvert(), "r"_a.noconvert(),
          "In each block, add rho / p . q times p to x, and take that times q = A p from r; returns r . r.\n\n"
          "A block whose rho is 0 stays.");
    m.def("block_turn", bound(&block_turn), "start"_a, "rho"_a, "last"_a, "z"_a, "p"_a.noconvert(),
          "In each block, make p the sum of z and rho / last times p; z where either is 0.");
    m.def("blocks_of_rows", bound(&blocks_of_rows), "block"_a, "column"_a, "place"_a, "of"_a,
          "The blocks of `block_rows`, (#, 4), of rows `of`; half of those on the diagonal is kept.");
    m.def("without_rows", bound(&without_rows), "start"_a, "column"_a, "block"_a, "x"_a, "r"_a,
          "r - R^T x, (n,), of rows R as of `block_rows`; r may be longer than they are.");
    m.def("left_at_rows", bound(&left_at_rows), "start"_a, "column"_a, "block"_a, "of"_a, "r"_a, "z"_a,
          "r - R z in the rows `of`, (2 #rows,).");
    bind_indexed<Index>(m);  // first, as what is of neither kind is converted to the first
    bind_indexed<std::int32_t>(m);
}

// The loops over graphs in CSR, whose indices SciPy has as int32 where these do.
template <class Int>
static void bind_searches(nb::module_& m) {
    using namespace graphs;
    m.def("nearest_sources", bound(&nearest_sources<Int>), "indptr"_a, "indices"_a, "length"_a, "sources"_a, "open_"_a,
        "limit"_a,
        R"(The distance of each node to the nearest source, the node before it on the path, and that source.

The graph is given as in CSR. Nodes that are not open are not reached, nor what is farther than `limit`: the
distance is infinite there, and the nodes are -1. A limit below 0 is one of 0.)");
    m.def("ways_towards", bound(&ways_towards<Int>), "indptr"_a, "indices"_a, "length"_a, "source"_a, "open_"_a,
        "position"_a, "targets"_a, "share"_a, "limit"_a,
        R"(The distances from a node, and the nodes before, where all ways on to the targets stay within a limit.

As in `nearest_sources`; what is farther may be left out. A way from a node, at `position` (n, 3), to each of the
`targets`, (#T, 3), is at least a `share` of the distance in space.)");
    m.def("meeting", bound(&meeting<Int>), "indptr"_a, "indices"_a, "length"_a, "sources"_a, "open_"_a, "limit"_a,
        R"(The ways to three sets of nodes from the node where they are shortest in total.

The nodes of the three ways, one after the other, each from there to the first one in the set; and where each way
begins, (4,). There are none if the total is over the limit. The graph is given as in CSR; nodes that are not open are
not passed, but those of a set by the way to it.)");
    m.def("far_apart", bound(&far_apart<Int>), "indptr"_a, "indices"_a, "order"_a, "hops"_a, "closed"_a,
        R"(A mask of the nodes that one takes in an order, leaving out those `hops` edges or less from taken ones.

The graph is given as in CSR. Closed nodes are neither taken nor passed.)");
}

static void bind_graphs(nb::module_& m) {
    using namespace graphs;
    bind_searches<Index>(m);
    bind_searches<std::int32_t>(m);
    m.def("undirected", bound(&undirected), "corner"_a, "n"_a,
        R"(The edges of triangles, (3, #F): their ends, (#E, 2), sides, (2, #E), and whether they are sound.

Ends and sides are as in `Topology`, the edges sorted by their lower and higher ends. They are sound where none has
more than two sides, or two that run the same way.)");
    m.def("in_edges", bound(&in_edges), "tail"_a, "head"_a, "n"_a,
        "Sides in the order of their edges, by vertices below n; where each edge begins, and how many it has.");
    m.def("used_vertices", bound(&used_vertices), "F"_a, "n"_a,
        "Which of n vertices sound faces have, and whether all are: indices in range, none of them twice.");
    m.def("entries", bound(&entries), "ends"_a, "n"_a,
        R"(The upper triangle of symmetric matrices over a graph of n rows; its edges join rows `ends`, (2, #E).

Returns indptr and indices as in CSR, the diagonal first in each row, and each edge's place among the entries; -1
where it joins a row to itself, or to none.)");
    m.def("shortest_pairs", bound(&shortest_pairs), "ends"_a, "length"_a, "n"_a,
        R"(The neighbours of each of n nodes, and the shortest edge to each, as in CSR; `ends` are (#E, 2).

Columns ascend. Of equally short edges it is the first one; edges from a node to itself are left out.)");
    m.def("boundary_loops", bound(&boundary_loops), "tail"_a, "head"_a, "n"_a,
        R"(Boundary half-edges chained into loops: their vertices one loop after the other, and their sizes.

A loop begins at its first vertex, and loops come in the order of these. There are none if two edges leave a vertex;
the third array has such vertices.)");
    m.def("cycles", bound(&cycles), "following"_a,
        "The cycles of a permutation, as lists, in the order of their first elements.");
    m.def("connected_labels", bound(&connected_labels), "edges"_a, "n"_a,
        R"(The component of each of the nodes 0 .. n - 1 of a graph with these edges, (#E, 2).

Components are numbered from 0, in the order of their first nodes.)");
    m.def("spanning_forest", bound(&spanning_forest), "pairs"_a, "order"_a, "n"_a,
        R"(Of the edges `order`, by their pairs of n nodes, those that close no cycle with earlier ones.

If the order is by weight, this is the minimum spanning forest (Kruskal 1956).)");
    m.def("is_connected", bound(&is_connected), "sides"_a, "n_faces"_a,
        "Whether every face can be reached from face 0 across edges; `sides` as in `Topology`.");
    m.def("fans_around", bound(&fans_around), "corner"_a, "sides"_a, "n"_a,
        "How many fans each of n vertices has, by the corners (3, #F) and the sides of edges of a `Topology`.");
    m.def("nodes_on_paths", bound(&nodes_on_paths), "before"_a, "ends"_a,
        R"(The nodes that lead from some ends to their sources, each once, in the order of the paths.

`before` is the node before each one on its path, and -1 at sources, which are left out.)");
    m.def("forest_parents", bound(&forest_parents), "pairs"_a, "n"_a,
        R"(The node above each of n nodes of a forest with these edges, (#E, 2); that of a root is itself.

The root of a tree is its first node.)");
    m.def("without_leaves", bound(&without_leaves), "ends"_a, "kept"_a,
        R"(The edges of a graph, by their ends (#E, 2), that are left when those at leaves are dropped in turn.

Leaves that are to be kept are none.)");
    m.def("arcs_between", bound(&arcs_between), "ends"_a, "joint"_a,
        R"(The edges of a graph, by their ends (#E, 2), in rows from joint to joint; then closed rows without any.

All nodes without exactly two edges have to be joints. Returns the edges of all arcs in their order, the nodes that
these pass, from the first to the last, and where the edges of each arc begin. The nodes of arc k begin k later, as it
has one more. Arcs begin in the order of edges.)");
    m.def("opened", bound(&opened), "ends"_a, "faces"_a, "seam"_a, "holes"_a, "n"_a, "n_faces"_a,
        R"(What a seam, edges of a graph on a surface, opens: its components and cycles, and the pieces.

`ends` and `faces` are the nodes and the faces of each edge, (#E, 2); the first nodes, the holes, are on the seam. The
pieces are given by their numbers of faces, ascending.)");
    m.def("behind_least_cut", bound(&behind_least_cut), "ends"_a, "capacity"_a, "n"_a, "source"_a, "sink"_a,
        R"(The nodes (n,) behind the least cut between two nodes; of several, the one nearest to the source.

Parameters
----------
ends : (#E, 2) int64
    Edges between different nodes.
capacity : (#E,) int64
    What it costs to cut each; below 2^31.
n, source, sink : int)");
}

static void bind_overlaps(nb::module_& m) {
    using namespace overlaps;
    m.attr("DEPTH") = DEPTH;
    m.def("overlapping", bound(&overlapping), "z"_a, "F"_a, "chart"_a,
          "Pairs of faces i < j of one chart that overlap in a map (#V,), in lexicographic order, (#P, 2).\n\n"
          "Each of the two reaches across all sides of the other by more than a millionth of the smaller one's\n"
          "height, and by more than the rounding of their corners. Collapsed faces overlap nothing.");
    m.def("lie_over", bound(&lie_over), "some"_a, "others"_a,
          "Whether one of some triangles, (#S, 3), overlaps another one of them, or one of others, (#O, 3).");
    m.def("overlap_sheets", bound(&overlap_sheets), "upper"_a, "lower"_a, "begin"_a, "neighbour"_a, "most"_a,
          "The two sheets of each of the `most` largest overlaps: the faces of each, ascending.\n\n"
          "And where each sheet begins, (2 #O + 1,).\n"
          "The pairs of faces, both ways around, are in lexicographic order, each once; the faces beside each\n"
          "face are given as in CSR. Pairs are neighbours if one face is the same, and the others are\n"
          "neighbours: so an overlap is a component of them, and of those the other way around. Where it winds\n"
          "on, so that a face is over one and under another, its sheets are grown from its first pair on until\n"
          "they meet. Each sheet is connected.");
    m.def("merge_regions", bound(&merge_regions), "triangle"_a, "depth"_a, "start"_a, "pairs"_a, "turn"_a, "shift"_a, "worth"_a,
          "page"_a,
          "The chart of each region, and the motion from the region's frame to the plane of the chart.\n\n"
          "Region r has the counter-clockwise triangles (#T, 3) from `start[r]` to `start[r + 1]`. One after the\n"
          "other, regions are joined by hinges with all that is joined to them, where the motion brings nothing\n"
          "of the one chart over the other. Triangles may reach into each other by the smaller of their\n"
          "`depth`; those of a negative one are not asked.\n"
          "Hinge h joins the regions `pairs[h]` = (a, b) by the motion of b's frame to a's, z -> `turn[h]` * z +\n"
          "`shift[h]`, where the rectangle around both charts takes at most `worth[h]` more than those around\n"
          "each, of a page of the area `page[h]`.");
}

static void bind_packing(nb::module_& m) {
    using namespace packing;
    m.def("rasterize", bound(&rasterize), "start"_a, "end"_a, "weight"_a, "sides"_a, "turns"_a, "of"_a, "half"_a,
        R"(The blocks of cells that turned outlines, widened by `half` to all four sides, touch.

Outline i has the sides from sides[i] to sides[i + 1], each with a weight. Mask k is that of outline
of[k], which ascends, times turns[k], in the smallest grid from its lower left corner; where turns[k] is
the opposite of the one before, of the same outline, it is that mask turned over.

Returns rows and columns (#M, 2), the corners (#M,), the blocks (#B, 4), those of a mask by size, and
where each mask's begin (#M + 1,).)");
    m.def("place_masks", bound(&place_masks), "side"_a, "most"_a, "spans"_a, "shapes"_a, "blocks"_a, "start"_a, "known"_a,
        R"(Charts on square pages with `side` cells along a side; each has several masks, one of which is chosen.

Those of chart i are from `spans[i, 0]` to `spans[i, 1]`; `shapes` are their rows and columns. Mask k has
the `blocks` from `start[k]` to `start[k + 1]`: the first row and column, the length and the number of
rows of equal runs of cells, the largest ones first. The places of the first charts may be `known`.

Returns the chart's mask, page, x and y; and the pages' widths and heights that are taken. If `most` pages
have no room for a chart, or an empty one has none, it and those after it have places of -1.)");
    m.def("taken_cells", bound(&taken_cells), "side"_a, "places"_a, "blocks"_a, "start"_a,
        "The cells (#pages, side, side) that charts at their places take, as `place_masks` gives these.");
    m.def("on_shelves", bound(&on_shelves), "sizes"_a, "taken"_a,
        R"(Lower left corners (#P, 2) of as many rectangles as find a place on a page.

A shelf is as high as its first rectangle. Where cells are taken, it goes on behind them.

Parameters
----------
sizes : (#R, 2) float64
    Widths and heights, the highest one first; in cells of the page.
taken : (side, side) bool
    Cells where nothing may come.)");
    m.def("narrowest_turns", bound(&narrowest_turns), "z"_a, "start"_a,
        R"(Of each group of points, the turn that makes the upright rectangle around it smallest.

Parameters
----------
z : (#P,) complex128
start : (#G + 1,) int64
    Group i has the points from start[i] to start[i + 1].

Returns
-------
turns : (#G,) complex128
    1 for points on a line.)");
    m.def("divisions", bound(&divisions), "points"_a, "ends"_a, "length"_a, "outer"_a, "normal"_a, "offset"_a,
        "outwards"_a,
        R"(What each line leaves of a graph in the plane, of which it cuts the edges that it crosses.

Parameters
----------
points : (#P, 2) float64
ends : (#E, 2) int64
length : (#E,) float64
    What it costs to cut an edge.
outer : (#P,) bool
    Points that may be on the convex hull of a part; those at edges that are cut are, too.
normal : (#L, 2) float64
offset : (#L,) float64
    Beyond line k are the points whose product with its normal is larger.
outwards : (2, 4 #D) float64
    Unit vectors by equal angles; the first one is (1, 0).

Returns
-------
hulls : (#L,) float64
    The area of the convex hulls of connected parts: of their points that are farthest out.
widest : (#L,) float64
    The longest diagonal of an upright rectangle around a part.
cut : (#L,) float64
    The lengths of the edges that are cut, added up.)");
}

static void bind_isometry(nb::module_& m) {
    using namespace isometry;
    m.def("isometric_energy", bound(&isometric_energy), "corner"_a, "gradient"_a, "share"_a, "z"_a, "weight"_a,
          "The energy of each triangle, times its share; infinite where a triangle is not upright.\n\n"
          "Its map w -> p w + q conj(w) has p = sum gradient z over the corners, and q the same of its conjugate.");
    m.def("isometric_rows", bound(&isometric_rows), "corner"_a, "gradient"_a, "share"_a, "z"_a, "weight"_a,
          "The slope of the energy, (6, #F), and rows, (24, #F): its convex part is the sum of row row^T.\n\n"
          "Four rows for a triangle, one after the other, each by x of the corners and then by y.");
    m.def("outer_products", bound(&outer_products), "rows"_a, "own"_a, "across"_a, "entries"_a,
          "The blocks, (entries, 4), of the sum of row row^T over triangles; `rows` has six rows for each.\n\n"
          "The block of corner k is added at own[k], that of the side opposite to it at across[k], and transposed at\n"
          "~across[k].");
    m.def("collapse_lengths", bound(&collapse_lengths), "corner"_a, "gradient"_a, "z"_a, "direction"_a,
          "The step length along `direction` at which each triangle collapses; infinite where none does.");
}

// Whether this processor has what the build for x86-64-v3 takes.
static bool has_v3() {
#if (defined(__GNUC__) || defined(__clang__)) && defined(__x86_64__)
    return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") && __builtin_cpu_supports("bmi2");
#elif defined(_MSC_VER) && defined(_M_X64)
    int leaf1[4], leaf7[4];
    __cpuidex(leaf1, 1, 0);
    __cpuidex(leaf7, 7, 0);
    const bool fma = leaf1[2] & (1 << 12), os = leaf1[2] & (1 << 27);
    const bool avx2 = leaf7[1] & (1 << 5), bmi2 = leaf7[1] & (1 << 8);
    return fma && os && avx2 && bmi2 && (_xgetbv(0) & 6) == 6;
#else
    return false;
#endif
}

NB_MODULE(MODULE, m) {
    m.def("has_v3", &has_v3, "Whether this processor runs the build for x86-64-v3.");
    bind_cholesky(m);
    bind_angles(m);
    bind_graphs(m);
    bind_isometry(m);
    bind_overlaps(m);
    bind_packing(m);
}
