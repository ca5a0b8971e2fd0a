// Bindings: triangles, the reduced system, maps, and conjugate gradients.
#include "boundary.hpp"
#include "bound.hpp"
#include "maps.hpp"
#include "reduced_system.hpp"
#include "symmetric.hpp"

using namespace angles;

// The loops over sparse matrices, whose indices are int64 or int32.
template <class I>
static void bind_indexed(nb::module_& m) {
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

static void bind_triangles(nb::module_& m) {
    m.def("developed_loops", bound(&developed_loops), "start"_a, "turning"_a, "log_ratio"_a, "movable"_a,
          "Positions of the vertices of loops, one after the other, and the loops' relative gaps.\n\n"
          "Loop i has the vertices start[i] to start[i + 1]; at each an exterior angle, the logarithm of the next edge's\n"
          "length over the last one's, and whether the angle may change so that those of the loop sum to 2 pi. Gaps are\n"
          "closed by the smallest change of lengths.");
    m.def("drawn_loops", bound(&drawn_loops), "vertex"_a, "start"_a, "turning"_a, "log_ratio"_a,
          "The gaps of loops that turn by -2 pi, in units of their lengths, and their derivatives by log_ratio + i turning\n"
          "at the vertices: the vector to the loop's end, minus its mean, over all vertices as the loop's start.");
    m.def("sum_by", bound(&sum_by), "index"_a, "values"_a, "n"_a, "Sum `values` over equal `index`, 0 .. n - 1.");
    m.def("products", bound(&products), "V"_a, "corner"_a,
          "Twice the areas, the scalar products, and the least double area that rounding does not make.");
    m.def("normals", bound(&normals), "V"_a, "corner"_a,
          "Unit normals of triangles, (#F, 3); zero, or what rounding makes of it, where there is no area.");
    m.def("bends", bound(&bends), "V"_a, "corner"_a, "sides"_a, "normal"_a,
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
    m.def("cut_short", bound(&cut_short), "alpha"_a, "e"_a, "reach"_a,
          "The errors, up to a share `reach` of the way to a vanishing angle; and where an angle would vanish.");
}

static void bind_system(nb::module_& m) {
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
}

static void bind_maps(nb::module_& m) {
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
}

static void bind_symmetric(nb::module_& m) {
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
}

void bind_angles(nb::module_& m) {
    bind_triangles(m);
    bind_system(m);
    bind_maps(m);
    bind_symmetric(m);
    bind_indexed<Index>(m);  // first, as what is of neither kind is converted to the first
    bind_indexed<std::int32_t>(m);
}
