// Flat regions put together in the plane, edge to edge, as long as nothing lies over anything else.
#pragma once
#include <array>

#include "../lists.hpp"
#include "separating_axes.hpp"

namespace overlaps {

constexpr double DEPTH = 0.5e-6;  // of the height of the smaller triangle, by which one may reach into another one
constexpr double LONG = 15;       // times what a chart that is too long for the page adds to it counts
constexpr int SIDES = 24;         // directions of those of rectangles around a chart
constexpr Index MOST_CELLS = 128;  // along a side of a grid
constexpr double WIDER = 1e-6;    // of a cell: rounding
constexpr double TINY = 1e-300;

// z -> turn z + shift, where |turn| = 1.
struct Motion {
    Complex turn{1, 0}, shift{0, 0};

    Complex operator()(Complex z) const { return times(turn, z) + shift; }
    Motion operator*(const Motion& first) const { return {times(turn, first.turn), (*this)(first.shift)}; }
    Motion inverse() const {
        const Complex back{turn.x, -turn.y};
        return {back, -1 * times(back, shift)};
    }

    Triangle operator()(const Triangle& t) const {
        Triangle moved = t;
        for (int k = 0; k < 3; ++k) moved.corner[k] = (*this)(t.corner[k]), moved.along[k] = times(turn, t.along[k]);
        return moved;
    }
    // A box around a box that is moved.
    Box operator()(const Box& b) const {
        const Complex centre = (*this)(b.centre());
        const double c = std::abs(turn.x), s = std::abs(turn.y);
        const double x = (c * b.width() + s * b.height()) / 2, y = (s * b.width() + c * b.height()) / 2;
        return {centre.x - x, centre.y - y, centre.x + x, centre.y + y};
    }
};

// How far a chart reaches in each of SIDES directions.
struct Extent {
    std::array<double, SIDES / 2> along, back;  // one direction, and the opposite one

    Extent() { along.fill(-INFINITY), back = along; }

    // Hold a box that is moved, too.
    void add(const Box& b, const Motion& by, const std::array<Complex, SIDES / 2>& axis) {
        const Complex centre = by(b.centre());
        const Complex right = b.width() / 2 * by.turn, up = times(by.turn, {0, b.height() / 2});
        for (int k = 0; k < SIDES / 2; ++k) {
            const double middle = dot(centre, axis[k]);
            const double reach = std::abs(dot(right, axis[k])) + std::abs(dot(up, axis[k]));
            along[k] = std::max(along[k], middle + reach);
            back[k] = std::max(back[k], reach - middle);
        }
    }
    // The area of the smallest rectangle along one of the directions; or what a long one takes of a page.
    double taken(double page) const {
        double least = INFINITY;
        for (int k = 0, other = SIDES / 4; other < SIDES / 2; ++k, ++other) {
            const double wide = along[k] + back[k], high = along[other] + back[other], longer = std::max(wide, high);
            least = std::min(least, std::max(wide * high, LONG * (longer * longer / 2 - page)));
        }
        return least;
    }
};

// The triangles of regions, those from start[r] to start[r + 1] in the frame of region r, in a grid for each region.
class Regions {
    struct Cells {
        Box box;
        Index columns = 1, rows = 1, first = 0;  // its first cell
    };
    std::vector<Triangle> triangle;
    View<const Index> start;
    std::vector<Cells> grid;
    Lists listed;  // the triangles in each cell

    // Call found(cell) for the cells that a triangle touches, until that is true; whether it was.
    template <class Found>
    static bool any_cell(const Triangle& t, const Cells& g, const Found& found) {
        const Box box = box_around(t.corner);
        const double high = g.box.height() / double(g.rows), per_row = double(g.rows) / std::max(g.box.height(), TINY);
        const double per_column = double(g.columns) / std::max(g.box.width(), TINY);
        const Index last_row = clamped((box.high - g.box.low) * per_row, 0, double(g.rows - 1));
        for (Index y = clamped((box.low - g.box.low) * per_row, 0, double(g.rows - 1)); y <= last_row; ++y) {
            // the part of a thin triangle in a row is in far fewer cells than the box around it
            const double floor = g.box.low + (double(y) - WIDER) * high, ceiling = floor + (1 + 2 * WIDER) * high;
            double left = INFINITY, right = -left;
            for (int k = 0; k < 3; ++k) {
                const Complex a = t.corner[k], b = t.corner[(k + 1) % 3];
                if (floor <= a.y && a.y <= ceiling)
                    left = std::min(left, a.x), right = std::max(right, a.x);
                for (const double level : {floor, ceiling}) {
                    if (!((a.y < level && level < b.y) || (b.y < level && level < a.y))) continue;
                    const double x = a.x + (level - a.y) / (b.y - a.y) * (b.x - a.x);
                    left = std::min(left, x), right = std::max(right, x);
                }
            }
            const Index last = clamped((right - g.box.left) * per_column + WIDER, -1, double(g.columns - 1));
            for (Index x = clamped((left - g.box.left) * per_column - WIDER, 0, double(g.columns - 1)); x <= last; ++x)
                if (found(g.first + y * g.columns + x)) return true;
        }
        return false;
    }

    // Call put(cell, triangle) for the cells that each triangle touches.
    template <class Put>
    void each_cell(const Put& put) const {
        for (Index r = 0; r < size(); ++r)
            for (Index t = start[r]; t < start[r + 1]; ++t)
                if (triangle[t].solid())
                    any_cell(triangle[t], grid[r], [&](Index cell) { return put(cell, t), false; });
    }

  public:
    Regions(Matrix<const Complex> corners, View<const double> depth, View<const Index> start)
        : triangle(corners.rows), start(start), grid(start.size - 1) {
        Index cells = 0;
        for (Index r = 0; r < size(); ++r) {
            Cells& g = grid[r];
            for (Index t = start[r]; t < start[r + 1]; ++t) {
                const Complex* z = corners[t];
                set_corners(triangle[t], z[0], z[1], z[2]);
                triangle[t].depth = depth[t];
                g.box.add(box_around(z));
            }
            const double number = double(start[r + 1] - start[r]), wide = g.box.width(), high = g.box.height();
            const double side = std::max(std::sqrt(wide * high / number), TINY);
            const double most = std::min(double(MOST_CELLS), number);
            g.columns = clamped(wide / side, 1, most), g.rows = clamped(high / side, 1, most), g.first = cells;
            cells += g.columns * g.rows;
        }
        listed = lists_of(cells, [&](const auto& put) { each_cell(put); });
    }

    Index size() const { return Index(grid.size()); }
    const Box& box(Index r) const { return grid[r].box; }

    // Whether a triangle of region s, moved to the frame of region r, overlaps one there.
    bool meet(Index r, Index s, const Motion& motion) const {
        if (start[s + 1] - start[s] > start[r + 1] - start[r]) return meet_moved(s, r, motion.inverse());
        return meet_moved(r, s, motion);
    }

  private:
    bool meet_moved(Index r, Index s, const Motion& motion) const {
        for (Index t = start[s]; t < start[s + 1]; ++t) {
            if (!triangle[t].solid()) continue;
            const Triangle moved = motion(triangle[t]);
            if (!grid[r].box.touches(box_around(moved.corner))) continue;
            const auto found = [&](Index cell) {
                for (const Index i : listed[cell])
                    if (overlap(triangle[i], moved)) return true;
                return false;
            };
            if (any_cell(moved, grid[r], found)) return true;
        }
        return false;
    }
};

// Where two regions a and b may be joined: by the motion of b's frame to a's, where the rectangle around both charts
// takes at most `worth` more than those around each, of a page of this area.
struct Hinge {
    Index a, b;
    Motion motion;
    double worth, page;
};

// Charts that regions are put together to: each region keeps its frame, and what changes is the motion from there to
// the plane of its chart. So two charts are joined in the time that it takes to move the regions of the smaller one,
// and triangles are found in grids that are made once.
class Assembly {
    const Regions& regions;
    std::array<Complex, SIDES / 2> axis;
    std::vector<std::vector<Index>> members;  // of each chart
    std::vector<Extent> extent;               // and of all of it
    std::vector<Box> box, around;             // of each region in its chart's plane, and of each chart

    // Whether the chart `there`, moved, overlaps the chart `here`.
    bool meet(Index here, Index there, const Motion& by) const {
        for (const Index s : members[there]) {
            const Motion own = by * motion[s];
            const Box near = own(regions.box(s));
            if (!near.touches(around[here])) continue;
            for (const Index r : members[here])
                if (near.touches(box[r]) && regions.meet(r, s, motion[r].inverse() * own)) return true;
        }
        return false;
    }

  public:
    std::vector<Index> chart;    // of each region
    std::vector<Motion> motion;  // of each region's frame to the plane of its chart

    explicit Assembly(const Regions& regions)
        : regions(regions), members(regions.size()), extent(regions.size()), box(regions.size()), around(box),
          chart(regions.size()), motion(regions.size()) {
        for (int k = 0; k < SIDES / 2; ++k) axis[k] = direction(2 * PI * k / SIDES);
        for (Index r = 0; r < regions.size(); ++r) {
            members[r] = {r}, chart[r] = r, box[r] = around[r] = regions.box(r);
            extent[r].add(box[r], {}, axis);
        }
    }

    // Join two charts, if they are worth it, and the motion brings nothing of the one over the other.
    void join(const Hinge& hinge) {
        Index here = chart[hinge.a], there = chart[hinge.b];
        if (here == there) return;
        Motion by = motion[hinge.a] * hinge.motion * motion[hinge.b].inverse();
        if (members[here].size() < members[there].size()) std::swap(here, there), by = by.inverse();
        Extent both = extent[here];
        for (const Index s : members[there]) both.add(regions.box(s), by * motion[s], axis);
        const double more = both.taken(hinge.page) - extent[here].taken(hinge.page) - extent[there].taken(hinge.page);
        if (!(more <= hinge.worth) || meet(here, there, by)) return;
        extent[here] = both;
        for (const Index s : members[there]) {
            motion[s] = by * motion[s];
            motion[s].turn = motion[s].turn / length(motion[s].turn);
            box[s] = motion[s](regions.box(s)), around[here].add(box[s]), chart[s] = here;
        }
        members[here].insert(members[here].end(), members[there].begin(), members[there].end());
        members[there].clear();
    }
};

struct Assembled {
    Array<Index> chart;
    Array<Complex> turn, shift;
};

// The chart of each region, and the motion from the region's frame to the plane of the chart. Hinge h joins the
// regions pairs[h] = (a, b) by the motion z -> turn[h] z + shift[h] of b's frame to a's.
inline Assembled merge_regions(Matrix<const Complex> triangle, View<const double> depth, View<const Index> start,
                           Matrix<const Index> pairs, View<const Complex> turn, View<const Complex> shift,
                           View<const double> worth, View<const double> page) {
    const Regions regions(triangle, depth, start);
    Assembly assembly(regions);
    for (Index h = 0; h < pairs.rows; ++h)
        assembly.join({pairs[h][0], pairs[h][1], {turn[h], shift[h]}, worth[h], page[h]});
    const Index n = regions.size();
    Assembled made{Array<Index>(n), Array<Complex>(n), Array<Complex>(n)};
    for (Index r = 0; r < n; ++r) {
        made.chart[r] = assembly.chart[r];
        made.turn[r] = assembly.motion[r].turn, made.shift[r] = assembly.motion[r].shift;
    }
    return made;
}

}  // namespace overlaps
