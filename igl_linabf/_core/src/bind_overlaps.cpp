#include "numpy.hpp"
#include "overlap_layers.hpp"
#include "overlapping.hpp"
#include "unfolding.hpp"

using overlaps::Complex;
using Indices = In1<const Index>;
using Complexes = In1<const Complex>;
using Numbers = In1<const double>;

static Out2<Index> overlapping(Complexes z, In2<const Index> F, Indices chart) {
    return out2(unlocked([&] { return overlaps::overlapping(view(z), matrix(F), view(chart)); }));
}

static bool lie_over(In2<const Complex> some, In2<const Complex> others) {
    return unlocked([&] { return overlaps::lie_over(matrix(some), matrix(others)); });
}

static auto overlap_sheets(Indices upper, Indices lower, Indices begin, Indices neighbour, Index most) {
    auto made = unlocked([&] {
        return overlaps::Layers(view(upper), view(lower), view(begin), view(neighbour)).largest(most);
    });
    return std::pair(out(std::move(made.faces)), out(std::move(made.start)));
}

static auto assembled(In2<const Complex> triangle, Numbers depth, Indices start, In2<const Index> pairs, Complexes turn,
                      Complexes shift, Numbers worth, Numbers page) {
    const Index n = Index(start.shape(0)) - 1;
    Array<Index> chart(n);
    Array<Complex> turns(n), shifts(n);
    unlocked([&] {
        const overlaps::Regions regions(matrix(triangle), view(depth), view(start));
        overlaps::Assembly assembly(regions);
        for (Index h = 0; h < Index(pairs.shape(0)); ++h)
            assembly.join({pairs(h, 0), pairs(h, 1), {turn(h), shift(h)}, worth(h), page(h)});
        for (Index r = 0; r < n; ++r) {
            chart[r] = assembly.chart[r];
            turns[r] = assembly.motion[r].turn, shifts[r] = assembly.motion[r].shift;
        }
    });
    return std::tuple(out(std::move(chart)), out(std::move(turns)), out(std::move(shifts)));
}

void bind_overlaps(nb::module_& m) {
    m.attr("DEPTH") = overlaps::DEPTH;
    m.def("overlapping", &overlapping, "z"_a, "F"_a, "chart"_a,
          "Pairs of faces i < j of one chart that overlap in a map (#V,), in lexicographic order, (#P, 2).\n\n"
          "Each of the two reaches across all sides of the other by more than a millionth of the smaller one's\n"
          "height, and by more than the rounding of their corners. Collapsed faces overlap nothing.");
    m.def("lie_over", &lie_over, "some"_a, "others"_a,
          "Whether one of some triangles, (#S, 3), overlaps another one of them, or one of others, (#O, 3).");
    m.def("overlap_sheets", &overlap_sheets, "upper"_a, "lower"_a, "begin"_a, "neighbour"_a, "most"_a,
          "The two sheets of each of the `most` largest overlaps: the faces of each, ascending.\n\n"
          "And where each sheet begins, (2 #O + 1,).\n"
          "The pairs of faces, both ways around, are in lexicographic order, each once; the faces beside each\n"
          "face are given as in CSR. Pairs are neighbours if one face is the same, and the others are\n"
          "neighbours: so an overlap is a component of them, and of those the other way around. Where it winds\n"
          "on, so that a face is over one and under another, its sheets are grown from its first pair on until\n"
          "they meet. Each sheet is connected.");
    m.def("assembled", &assembled, "triangle"_a, "depth"_a, "start"_a, "pairs"_a, "turn"_a, "shift"_a, "worth"_a,
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
