// Parallel sparse Cholesky factorization of symmetric positive definite matrices with a common pattern.
#pragma once
#include <limits>
#include <stdexcept>

#include "../threads.hpp"
#include "minimum_degree.hpp"
#include "substitution.hpp"

#ifdef __GLIBC__
#include <malloc.h>
#endif

namespace cholesky {

class Factor;

// A pattern of 2 by 2 blocks expanded to entries: the lower triangle in CSC,
// and the position of each entry among the values of the blocks.
// Entry (i, j) of the pattern stands for the block in the rows 2 j, 2 j + 1 and the columns 2 i,
// 2 i + 1 of the upper triangle.
struct ExpandedBlocks {
    std::vector<Index> indptr{0}, indices, source;

    template <class I>
    ExpandedBlocks(View<const I> begin, View<const I> row) {
        for (Index j = 0; j + 1 < begin.size; ++j)
            for (Index c = 0; c < 2; indptr.push_back(Index(indices.size())), ++c)
                for (Index p = begin[j]; p < Index(begin[j + 1]); ++p)
                    for (Index r = row[p] == j ? c : 0; r < 2; ++r)
                        indices.push_back(2 * row[p] + r), source.push_back(4 * p + 2 * c + r);
    }
};

// The symbolic analysis of a sparsity pattern.
class Symbolic {
    friend class Factor;
    Supernodes a;
    TreePartition parts;
    mutable Array<double> spare;  // reused memory of a destroyed factor; allocation takes up to 1/3 of the time
    mutable std::mutex spare_mutex;

  public:
    Index entries;  // number of stored values of a matrix with this pattern

    // Analyse a lower triangle in CSC with the diagonal entry first in each column.
    // Each entry stands for a block of `block` rows and columns.
    template <class I>
    Symbolic(View<const I> indptr, View<const I> indices, int block) {
        const Index n = indptr.size - 1, most = std::numeric_limits<RowIndex>::max();
        if (block != 1 && block != 2) throw std::invalid_argument("block is 1 or 2");
        entries = indices.size * block * block;
        bool good = n >= 0 && indptr[0] == 0 && Index(indptr[n]) == indices.size;
        for (Index j = 0; good && j < n; ++j) {
            good = indptr[j] < indptr[j + 1] && indptr[j + 1] <= indices.size && indices[indptr[j]] == j;
            for (Index p = indptr[j] + 1; good && p < indptr[j + 1]; ++p) good = j < indices[p] && indices[p] < n;
        }
        if (!good) throw std::invalid_argument("not a lower triangle in CSC with the diagonal first in each column");
        if (block * n > most || entries > most) throw std::invalid_argument("too many entries");
        std::vector<Index> order = MinimumDegree<I>(indptr, indices).order();
        if (block == 1) {
            a = analyse_supernodes(indptr, indices, std::move(order));
        } else {
            const ExpandedBlocks each(indptr, indices);
            std::vector<Index> twice(2 * order.size());
            for (std::size_t i = 0; i < twice.size(); ++i) twice[i] = 2 * order[i / 2] + Index(i % 2);
            a = analyse_supernodes<Index>(each.indptr, each.indices, std::move(twice));
            for (FrontIndex& k : a.source) k = FrontIndex(each.source[k]);
        }
        parts = partition_tree(a);
#ifdef __GLIBC__
        if (a.n >= PARALLEL_ROWS) malloc_trim(0);  // return the large free part of the heap to the system
#endif
    }

    Index rows() const { return a.n; }
    Index bytes() const { return Index(sizeof(double)) * a.value_start.back(); }  // memory of the values of a factor
};

class Factor {
    std::shared_ptr<const Symbolic> of;
    Array<double> values;

    Array<double> reuse_memory() const {
        const std::lock_guard held(of->spare_mutex);
        return of->spare.data() ? std::move(of->spare) : Array<double>(of->a.value_start.back());
    }

    // Call work(supernodes, root) for each subtree of the partitioned elimination tree, in parallel.
    template <class Work>
    void for_each_subtree(const Work& work) const {
        parallel_for(Index(of->parts.subtrees.size()), [&](Index k) {
            work(of->parts.subtrees[k], of->parts.subtrees[k].back());
        });
    }

    // Solve for S right-hand sides: the columns k to k + S - 1 of B, which has `sides` columns in total.
    template <int S>
    void solve_sides(const double* B, Index sides, Index k, double* X) const {
        Array<double> x(of->a.n, S), left(of->parts.rows.back(), S);
        std::fill_n(x.data(), x.size(), 0.0);
        const auto down = [&](const std::vector<Index>& which, Index root) {
            solve_lower<S>(values.data(), of->a, of->parts, which, root, B + k, sides, left.data(), x.data());
        };
        const auto up = [&](const std::vector<Index>& which, Index root) {
            solve_upper<S>(values.data(), of->a, of->parts, which, root, x.data(), X + k, sides);
        };
        for_each_subtree(down);
        down(of->parts.rest, -1);
        up(of->parts.rest, -1);
        for_each_subtree(up);
    }

  public:
    Index bad_row = -1;  // row of the first pivot that is not positive and finite

    Factor(std::shared_ptr<const Symbolic> symbolic, View<const double> data)
        : of(std::move(symbolic)), values(reuse_memory()) {
        Array<double> left(of->parts.left.back());
        std::vector<Index> bad(of->parts.subtrees.size() + 1, -1);
        const auto work = [&](const std::vector<Index>& which, Index root) {
            bad[root < 0 ? bad.size() - 1 : of->parts.number[root]] =
                factor_supernodes(data, of->a, of->parts, which, root, values.data(), left.data());
        };
        const auto found = [](Index place) { return place >= 0; };
        for_each_subtree(work);
        if (std::none_of(bad.begin(), bad.end(), found)) work(of->parts.rest, -1);
        const auto first = std::find_if(bad.begin(), bad.end(), found);
        if (first != bad.end()) bad_row = of->a.order[*first];
    }

    Factor(const Factor&) = delete;

    ~Factor() {
        const std::lock_guard held(of->spare_mutex);
        of->spare = std::move(values);
    }

    Index rows() const { return of->a.n; }

    // Return X, (n, sides), such that A X = B. X and B are in row-major order.
    Array<double> solve(const double* B, Index sides) const {
        Array<double> X(of->a.n, sides);
        Index k = 0;
        for (; sides - k >= 8; k += 8) solve_sides<8>(B, sides, k, X.data());
        for (; sides - k >= 4; k += 4) solve_sides<4>(B, sides, k, X.data());
        for (; sides - k >= 2; k += 2) solve_sides<2>(B, sides, k, X.data());
        if (k < sides) solve_sides<1>(B, sides, k, X.data());
        return X;
    }
};

}  // namespace cholesky
