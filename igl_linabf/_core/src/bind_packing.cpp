// Outlines as masks, masks and rectangles on pages, and what else charts are packed by.
#include <cstring>

#include "bitmap_packing.hpp"
#include "cut_lines.hpp"
#include "numpy.hpp"
#include "rasterize.hpp"
#include "rectangles.hpp"

using namespace packing;
using Complex = std::complex<double>;

namespace {

View<const Point> points(const In1<const Complex>& z) {
    return {reinterpret_cast<const Point*>(z.data()), Index(z.shape(0))};
}
Out1<Complex> complex(View<const Point> z) {
    Array<Complex> made(z.size);
    for (Index i = 0; i < z.size; ++i) made[i] = {z[i].x, z[i].y};
    return out(std::move(made));
}

// Rows of as many indices as a struct has, as these structs.
template <class T>
using Rows = nb::ndarray<const Index, nb::shape<-1, sizeof(T) / sizeof(Index)>, nb::c_contig, nb::device::cpu>;
template <class T>
View<const T> structs(const nb::ndarray<const Index, nb::shape<-1, sizeof(T) / sizeof(Index)>, nb::c_contig,
                                        nb::device::cpu>& a) {
    return {reinterpret_cast<const T*>(a.data()), Index(a.shape(0))};
}
template <class T, class U>
Out2<T> rows_of(const std::vector<U>& structs) {
    Array<T> made(Index(structs.size()), sizeof(U) / sizeof(T));
    if (made.size()) std::memcpy(made.data(), structs.data(), structs.size() * sizeof(U));
    return out2(std::move(made));
}

}  // namespace

void bind_packing(nb::module_& m) {
    m.def(
        "drawn",
        [](In1<const Complex> start, In1<const Complex> end, In1<const Index> weight, In1<const Index> sides,
           In1<const Complex> turns, In1<const Index> of, double half) {
            Drawn made = unlocked([&] {
                return drawn(points(start), points(end), view(weight), view(sides), points(turns), view(of), half);
            });
            return std::tuple(rows_of<Index>(made.shapes), complex(made.low), rows_of<Index>(made.blocks),
                              out(std::move(made.begin)));
        },
        "start"_a, "end"_a, "weight"_a, "sides"_a, "turns"_a, "of"_a, "half"_a,
        R"(The blocks of cells that turned outlines, widened by `half` to all four sides, touch.

Outline i has the sides from sides[i] to sides[i + 1], each with a weight. Mask k is that of outline
of[k], which ascends, times turns[k], in the smallest grid from its lower left corner; where turns[k] is
the opposite of the one before, of the same outline, it is that mask turned over.

Returns rows and columns (#M, 2), the corners (#M,), the blocks (#B, 4), those of a mask by size, and
where each mask's begin (#M + 1,).)");
    m.def(
        "placed",
        [](Index side, Index most, Rows<Span> spans, Rows<Shape> shapes, Rows<Block> blocks, In1<const Index> start,
           Rows<Place> known) {
            const auto [places, extents] = unlocked([&] {
                return placed(side, most, structs<Span>(spans), structs<Shape>(shapes), structs<Block>(blocks),
                              view(start), structs<Place>(known));
            });
            return std::pair(rows_of<Index>(places), rows_of<Index>(extents));
        },
        "side"_a, "most"_a, "spans"_a, "shapes"_a, "blocks"_a, "start"_a, "known"_a,
        R"(Charts on square pages with `side` cells along a side; each has several masks, one of which is chosen.

Those of chart i are from `spans[i, 0]` to `spans[i, 1]`; `shapes` are their rows and columns. Mask k has
the `blocks` from `start[k]` to `start[k + 1]`: the first row and column, the length and the number of
rows of equal runs of cells, the largest ones first. The places of the first charts may be `known`.

Returns the chart's mask, page, x and y; and the pages' widths and heights that are taken. If `most` pages
have no room for a chart, or an empty one has none, it and those after it have places of -1.)");
    m.def(
        "taken_cells",
        [](Index side, Rows<Place> places, Rows<Block> blocks, In1<const Index> start) {
            Array<bool> taken = unlocked(
                [&] { return taken_cells(side, structs<Place>(places), structs<Block>(blocks), view(start)); });
            const auto cells = std::size_t(side), pages = side ? std::size_t(taken.rows) / cells : 0;
            bool* const data = taken.release();
            return nb::ndarray<nb::numpy, bool, nb::ndim<3>>(
                data, {pages, cells, cells},
                nb::capsule(data, [](void* p) noexcept { delete[] static_cast<bool*>(p); }));
        },
        "side"_a, "places"_a, "blocks"_a, "start"_a,
        "The cells (#pages, side, side) that charts at their places take, as `placed` gives these.");
    m.def(
        "on_shelves",
        [](In2<const double> sizes, In2<const bool> taken) {
            return rows_of<double>(unlocked([&] { return on_shelves(matrix(sizes), matrix(taken)); }));
        },
        "sizes"_a, "taken"_a,
        R"(Lower left corners (#P, 2) of as many rectangles as find a place on a page.

A shelf is as high as its first rectangle. Where cells are taken, it goes on behind them.

Parameters
----------
sizes : (#R, 2) float64
    Widths and heights, the highest one first; in cells of the page.
taken : (side, side) bool
    Cells where nothing may come.)");
    m.def(
        "narrowest_turns",
        [](In1<const Complex> z, In1<const Index> start) {
            return complex(unlocked([&] { return narrowest_turns(points(z), view(start)); }));
        },
        "z"_a, "start"_a,
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
    m.def(
        "divisions",
        [](In2<const double> points, In2<const Index> ends, In1<const double> length, In1<const bool> outer,
           In2<const double> normal, In1<const double> offset, In2<const double> outwards) {
            Divisions made = unlocked([&] {
                return divisions(matrix(points), matrix(ends), view(length), view(outer), matrix(normal),
                                 view(offset), matrix(outwards));
            });
            return std::tuple(out(std::move(made.hulls)), out(std::move(made.widest)), out(std::move(made.cut)));
        },
        "points"_a, "ends"_a, "length"_a, "outer"_a, "normal"_a, "offset"_a, "outwards"_a,
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
