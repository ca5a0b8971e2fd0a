// Assembly of flat regions in the plane, edge to edge, without overlaps.
#pragma once
#include <array>

#include "../lists.hpp"
#include "separating_axes.hpp"

namespace overlaps {

constexpr double DEPTH = 0.5e-6;        // overlaps up to this share of the smaller triangle's height are ignored
constexpr double OVERLONG_WEIGHT = 15;  // weight of the page area that an overlong chart wastes
constexpr int EXTENT_DIRECTIONS = 24;               // number of directions for measuring the extent of a chart
constexpr Index MAX_GRID_SIDE = 128;    // maximum number of cells along one side of a grid
constexpr double CELL_MARGIN = 1e-6;    // margin for rounding errors, relative to the cell size
constexpr double MIN_EXTENT = 1e-300;   // minimum width or height, to avoid divisions by zero

// A rigid motion z -> turn z + shift, where |turn| = 1.
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
    // Return the bounding box of a moved box.
    Box operator()(const Box& b) const {
        const Complex centre = (*this)(b.centre());
        const double c = std::abs(turn.x), s = std::abs(turn.y);
        const double x = (c * b.width() + s * b.height()) / 2, y = (s * b.width() + c * b.height()) / 2;
        return {centre.x - x, centre.y - y, centre.x + x, centre.y + y};
    }
};

// The extent of a chart in each of EXTENT_DIRECTIONS directions.
struct ChartExtent {
    std::array<double, EXTENT_DIRECTIONS / 2> along, back;  // extents in each direction and in the opposite direction

    ChartExtent() { along.fill(-INFINITY), back = along; }

    // Enlarge the extent to contain a moved box.
    void add(const Box& b, const Motion& by, const std::array<Complex, EXTENT_DIRECTIONS / 2>& axis) {
        const Complex centre = by(b.centre());
        const Complex right = b.width() / 2 * by.turn, up = times(by.turn, {0, b.height() / 2});
        for (int k = 0; k < EXTENT_DIRECTIONS / 2; ++k) {
            const double middle = dot(centre, axis[k]);
            const double reach = std::abs(dot(right, axis[k])) + std::abs(dot(up, axis[k]));
            along[k] = std::max(along[k], middle + reach);
            back[k] = std::max(back[k], reach - middle);
        }
    }
    // Return the area of the smallest bounding rectangle along one of the directions, with a penalty if it is overlong.
    double used_area(double page) const {
        double least = INFINITY;
        for (int k = 0, other = EXTENT_DIRECTIONS / 4; other < EXTENT_DIRECTIONS / 2; ++k, ++other) {
            const double wide = along[k] + back[k], high = along[other] + back[other], longer = std::max(wide, high);
            least = std::min(least, std::max(wide * high, OVERLONG_WEIGHT * (longer * longer / 2 - page)));
        }
        return least;
    }
};

// The triangles of all regions, with a grid for each region to find the triangles near a point.
// Region r has the triangles start[r] to start[r + 1] - 1, in its own frame.
class Regions {
    struct Cells {
        Box box;
        Index columns = 1, rows = 1, first = 0;  // first is the index of the first cell
    };
    std::vector<Triangle> triangle;
    View<const Index> start;
    std::vector<Cells> grid;
    Lists listed;  // triangles in each cell

    // Call found(cell) for the cells that a triangle touches, until a call returns true. Return true if a call did.
    template <class Found>
    static bool visit_cells(const Triangle& t, const Cells& g, const Found& found) {
        const Box box = bounding_box(t.corner);
        const double high = g.box.height() / double(g.rows);
        const double per_row = double(g.rows) / std::max(g.box.height(), MIN_EXTENT);
        const double per_column = double(g.columns) / std::max(g.box.width(), MIN_EXTENT);
        const Index last_row = clamp_index((box.high - g.box.low) * per_row, 0, double(g.rows - 1));
        for (Index y = clamp_index((box.low - g.box.low) * per_row, 0, double(g.rows - 1)); y <= last_row; ++y) {
            // clip the triangle to the row, because a thin triangle touches far fewer cells than its bounding box
            const double floor = g.box.low + (double(y) - CELL_MARGIN) * high;
            const double ceiling = floor + (1 + 2 * CELL_MARGIN) * high;
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
            const Index last = clamp_index((right - g.box.left) * per_column + CELL_MARGIN, -1, double(g.columns - 1));
            Index x = clamp_index((left - g.box.left) * per_column - CELL_MARGIN, 0, double(g.columns - 1));
            for (; x <= last; ++x)
                if (found(g.first + y * g.columns + x)) return true;
        }
        return false;
    }

    // Call put(cell, triangle) for each triangle and each cell that it touches.
    template <class Put>
    void for_each_cell(const Put& put) const {
        for (Index r = 0; r < size(); ++r)
            for (Index t = start[r]; t < start[r + 1]; ++t)
                if (triangle[t].is_solid())
                    visit_cells(triangle[t], grid[r], [&](Index cell) { return put(cell, t), false; });
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
                g.box.add(bounding_box(z));
            }
            const double number = double(start[r + 1] - start[r]), wide = g.box.width(), high = g.box.height();
            const double side = std::max(std::sqrt(wide * high / number), MIN_EXTENT);
            const double most = std::min(double(MAX_GRID_SIDE), number);
            g.columns = clamp_index(wide / side, 1, most), g.rows = clamp_index(high / side, 1, most), g.first = cells;
            cells += g.columns * g.rows;
        }
        listed = build_lists(cells, [&](const auto& put) { for_each_cell(put); });
    }

    Index size() const { return Index(grid.size()); }
    const Box& box(Index r) const { return grid[r].box; }

    // Return true if a triangle of region s, moved to the frame of region r, overlaps a triangle of region r.
    bool does_collide(Index r, Index s, const Motion& motion) const {
        if (start[s + 1] - start[s] > start[r + 1] - start[r]) return does_moved_collide(s, r, motion.inverse());
        return does_moved_collide(r, s, motion);
    }

  private:
    bool does_moved_collide(Index r, Index s, const Motion& motion) const {
        for (Index t = start[s]; t < start[s + 1]; ++t) {
            if (!triangle[t].is_solid()) continue;
            const Triangle moved = motion(triangle[t]);
            if (!grid[r].box.intersects(bounding_box(moved.corner))) continue;
            const auto found = [&](Index cell) {
                for (const Index i : listed[cell])
                    if (do_overlap(triangle[i], moved)) return true;
                return false;
            };
            if (visit_cells(moved, grid[r], found)) return true;
        }
        return false;
    }
};

// A hinge that may join two regions a and b.
// `motion` maps the frame of b to that of a.
// The charts are joined if the area of the rectangle around both charts exceeds the total area
// of the rectangles around each chart by at most `worth`.
// `page` is the area of a page.
struct Hinge {
    Index a, b;
    Motion motion;
    double worth, page;
};

// The assembly of regions into charts.
// Regions keep their frames; only the motions from the frames to the planes of their charts change.
// Therefore, joining two charts takes time proportional to the regions of the smaller chart,
// and the grids of triangles are built only once.
class Assembly {
    const Regions& regions;
    std::array<Complex, EXTENT_DIRECTIONS / 2> axis;
    std::vector<std::vector<Index>> members;  // regions of each chart
    std::vector<ChartExtent> extent;          // extent of each chart
    std::vector<Box> box, around;             // box of each region in the plane of its chart, and box of each chart

    // Return true if the chart `there`, after the motion `by`, overlaps the chart `here`.
    bool does_collide(Index here, Index there, const Motion& by) const {
        for (const Index s : members[there]) {
            const Motion own = by * motion[s];
            const Box near = own(regions.box(s));
            if (!near.intersects(around[here])) continue;
            for (const Index r : members[here])
                if (near.intersects(box[r]) && regions.does_collide(r, s, motion[r].inverse() * own)) return true;
        }
        return false;
    }

  public:
    std::vector<Index> chart;    // chart of each region
    std::vector<Motion> motion;  // from the frame of each region to the plane of its chart

    explicit Assembly(const Regions& regions)
        : regions(regions), members(regions.size()), extent(regions.size()), box(regions.size()), around(box),
          chart(regions.size()), motion(regions.size()) {
        for (int k = 0; k < EXTENT_DIRECTIONS / 2; ++k) axis[k] = direction(2 * PI * k / EXTENT_DIRECTIONS);
        for (Index r = 0; r < regions.size(); ++r) {
            members[r] = {r}, chart[r] = r, box[r] = around[r] = regions.box(r);
            extent[r].add(box[r], {}, axis);
        }
    }

    // Join two charts unless the joint rectangle is too large or the charts would overlap.
    void join(const Hinge& hinge) {
        Index here = chart[hinge.a], there = chart[hinge.b];
        if (here == there) return;
        Motion by = motion[hinge.a] * hinge.motion * motion[hinge.b].inverse();
        if (members[here].size() < members[there].size()) std::swap(here, there), by = by.inverse();
        ChartExtent both = extent[here];
        for (const Index s : members[there]) both.add(regions.box(s), by * motion[s], axis);
        const double more =
            both.used_area(hinge.page) - extent[here].used_area(hinge.page) - extent[there].used_area(hinge.page);
        if (!(more <= hinge.worth) || does_collide(here, there, by)) return;
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

struct MergedRegions {
    Array<Index> chart;
    Array<Complex> turn, shift;
};

// Join regions to charts, hinge by hinge.
// Returns the chart of each region, and the motion from the frame of the region to the plane of the chart.
// Hinge h joins the regions pairs[h] = (a, b) by the motion z -> turn[h] z + shift[h] from the frame of b to that of a.
inline MergedRegions merge_regions(Matrix<const Complex> triangle, View<const double> depth, View<const Index> start,
                                   Matrix<const Index> pairs, View<const Complex> turn, View<const Complex> shift,
                                   View<const double> worth, View<const double> page) {
    const Regions regions(triangle, depth, start);
    Assembly assembly(regions);
    for (Index h = 0; h < pairs.rows; ++h)
        assembly.join({pairs[h][0], pairs[h][1], {turn[h], shift[h]}, worth[h], page[h]});
    const Index n = regions.size();
    MergedRegions result{Array<Index>(n), Array<Complex>(n), Array<Complex>(n)};
    for (Index r = 0; r < n; ++r) {
        result.chart[r] = assembly.chart[r];
        result.turn[r] = assembly.motion[r].turn, result.shift[r] = assembly.motion[r].shift;
    }
    return result;
}

}  // namespace overlaps
