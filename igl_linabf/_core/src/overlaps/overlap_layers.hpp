// Division of each overlap of a flat map into two sheets: connected sets of faces, one of which lies above the other.
#pragma once
#include <numeric>

#include "../arrays.hpp"

namespace overlaps {

constexpr double GROWTH_SHARE = 0.8;  // sheets that would meet stop growing after this share of the pairs up to there

struct Sheets {
    std::vector<Index> faces, start{0};
};

// The overlapping pairs of faces, in both orders and sorted lexicographically,
// and the adjacent faces of each face in CSR.
// Two pairs are neighbours if they have one face in common and their other faces are adjacent.
// An overlap is a connected component of pairs together with the mirrored component.
class OverlapLayers {
    View<const Index> upper, lower, begin, neighbour;
    std::vector<Index> row;              // first pair of each upper face
    std::vector<Index> component;        // component of each pair
    std::vector<Index> queue, first{0};  // pairs by component in breadth-first order, and start of each component
    std::vector<Index> sheet, when[2];   // sheet of each face, and its first pair as upper and as lower face

    // Return the index of a pair, or -1 if it does not exist.
    Index find(Index one, Index other) const {
        const auto last = lower.begin() + row[one + 1];
        const auto at = std::lower_bound(lower.begin() + row[one], last, other);
        return at < last && *at == other ? at - lower.begin() : -1;
    }

    // Append all pairs that are connected to a pair to the queue, in breadth-first order.
    // Mark the pairs of the mirrored component, too. Return the number of pairs of both components.
    Index flood_fill(Index seed) {
        const Index own = Index(first.size()) - 1;
        std::vector<Index> beside;
        queue.push_back(seed), component[seed] = own;
        for (Index done = first.back(); done < Index(queue.size()); ++done) {
            const Index one = upper[queue[done]], other = lower[queue[done]];
            beside.clear();
            for (Index k = begin[one]; k < begin[one + 1]; ++k) beside.push_back(find(neighbour[k], other));
            for (Index k = begin[other]; k < begin[other + 1]; ++k) beside.push_back(find(one, neighbour[k]));
            std::sort(beside.begin(), beside.end());
            for (const Index pair : beside)
                if (pair >= 0 && component[pair] != own) component[pair] = own, queue.push_back(pair);
        }
        Index size = Index(queue.size()) - first.back();
        for (Index k = first.back(); k < Index(queue.size()); ++k)
            if (const Index pair = find(lower[queue[k]], upper[queue[k]]); pair >= 0 && component[pair] < 0)
                component[pair] = own, ++size;
        first.push_back(Index(queue.size()));
        return size;
    }

    // Append the faces that are connected to `face` within its sheet, ascending, and remove them from the sheet.
    void extract_component(Index face, Sheets& result) {
        const std::size_t before = result.faces.size();
        const Index own = sheet[face];
        result.faces.push_back(face), sheet[face] = 0;
        for (std::size_t done = before; done < result.faces.size(); ++done)
            for (Index k = begin[result.faces[done]]; k < begin[result.faces[done] + 1]; ++k)
                if (own && sheet[neighbour[k]] == own) result.faces.push_back(neighbour[k]), sheet[neighbour[k]] = 0;
        std::sort(result.faces.begin() + before, result.faces.end());
        result.start.push_back(Index(result.faces.size()));
    }

    // Append the two sheets of an overlap, which grow from its first pair until a face would belong to both sheets.
    void append_sheets(View<const Index> pairs, Sheets& result) {
        const auto each_face = [&](const auto& visit) {
            for (const Index pair : pairs) visit(upper[pair]), visit(lower[pair]);
        };
        const Index size = pairs.size;
        for (Index at = size; at-- > 0;) when[0][upper[pairs[at]]] = at, when[1][lower[pairs[at]]] = at;
        Index met = size;
        each_face([&](Index f) { met = std::min(met, std::max(when[0][f], when[1][f])); });
        const double limit = met == size ? double(met) : GROWTH_SHARE * double(met);
        each_face([&](Index f) { sheet[f] = when[0][f] < limit ? 1 : when[1][f] < limit ? 2 : 0; });
        const Index one = upper[pairs[0]], other = lower[pairs[0]];
        sheet[one] = 1, sheet[other] = 2;
        extract_component(one, result), extract_component(other, result);
        each_face([&](Index f) { sheet[f] = 0, when[0][f] = when[1][f] = upper.size; });
    }

  public:
    OverlapLayers(View<const Index> upper, View<const Index> lower, View<const Index> begin,
                  View<const Index> neighbour)
        : upper(upper), lower(lower), begin(begin), neighbour(neighbour), row(begin.size), component(upper.size, -1),
          sheet(begin.size - 1) {
        when[0] = when[1] = std::vector<Index>(sheet.size(), upper.size);
        for (const Index face : upper) ++row[face + 1];
        std::partial_sum(row.begin(), row.end(), row.begin());
    }

    // Return the two sheets of the largest overlaps, of at most `most` overlaps.
    Sheets largest_overlaps(Index most) {
        std::vector<Index> size;  // number of pairs of each component and its mirrored component
        for (Index k = 0; k < upper.size; ++k)
            if (component[k] < 0) size.push_back(flood_fill(k));
        std::vector<Index> order(size.size());
        std::iota(order.begin(), order.end(), Index(0));
        std::stable_sort(order.begin(), order.end(), [&](Index a, Index b) { return size[a] > size[b]; });
        Sheets result;
        const View<const Index> pairs = queue;
        for (Index k = 0; k < std::min(most, Index(order.size())); ++k)
            append_sheets(pairs.part(first[order[k]], first[order[k] + 1]), result);
        return result;
    }
};

// Return the two sheets of each of the `most` largest overlaps. For all other parameters, see `OverlapLayers`.
inline Sheets overlap_sheets(View<const Index> upper, View<const Index> lower, View<const Index> begin,
                             View<const Index> neighbour, Index most) {
    return OverlapLayers(upper, lower, begin, neighbour).largest_overlaps(most);
}

}  // namespace overlaps
