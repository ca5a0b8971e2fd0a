// The Cholesky factor, for Python: a pattern is analysed once, its values are factored anew.
#include <stdexcept>

#include "cholesky.hpp"
#include "numpy.hpp"

using Data = nb::ndarray<const double, nb::c_contig, nb::device::cpu>;

// Analyse the lower triangle of a pattern; raises ValueError if it is none.
template <class I>
static void analyse(Symbolic* self, In1<const I> indptr, In1<const I> indices, int block) {
    const auto begin = view(indptr), row = view(indices);
    constexpr Index most = std::numeric_limits<Number>::max();
    if (block != 1 && block != 2) throw std::invalid_argument("block is 1 or 2");
    unlocked([&] {
        const Index n = begin.size - 1;
        bool good = n >= 0 && begin[0] == 0 && Index(begin[n]) == row.size;
        for (Index j = 0; good && j < n; ++j) {
            good = begin[j] < begin[j + 1] && begin[j + 1] <= row.size && row[begin[j]] == j;
            for (Index p = begin[j] + 1; good && p < begin[j + 1]; ++p) good = j < row[p] && row[p] < n;
        }
        if (!good) throw std::invalid_argument("no lower triangle in CSC with the diagonal first in each column");
        if (block * n > most || block * block * row.size > most) throw std::invalid_argument("too many entries");
        new (self) Symbolic(begin, row, block);
    });
}

void bind_cholesky(nb::module_& m) {
    nb::class_<Factor>(m, "Factor", "A matrix that can be solved with.")
        .def_ro("bad_row", &Factor::bad_row, "Row of the first pivot that is not positive and finite; -1 if none is.")
        .def("solve", [](const Factor& self, Data B) -> nb::object {
            if (B.ndim() < 1 || B.ndim() > 2 || Index(B.shape(0)) != self.rows())
                throw std::invalid_argument("the right-hand sides have another number of rows than the matrix");
            Array<double> X = unlocked([&] { return self.solve(B.data(), B.ndim() == 2 ? Index(B.shape(1)) : 1); });
            return B.ndim() == 2 ? nb::cast(out2(std::move(X))) : nb::cast(out(std::move(X)));
        }, "B"_a, "X of A X = B, for (n,) or (n, k).");
    nb::class_<Symbolic>(m, "Symbolic",
                         "What is known of a symmetric pattern before it has values: order, tree and supernodes.\n\n"
                         "Given by its lower triangle in CSC, the diagonal first in each column. With `block` 2, each "
                         "entry is a 2 by 2 block.")
        .def("__init__", &analyse<std::int32_t>, "indptr"_a, "indices"_a, "block"_a = 1)
        .def("__init__", &analyse<std::int64_t>, "indptr"_a, "indices"_a, "block"_a = 1)
        .def_prop_ro("bytes", &Symbolic::bytes, "What a factor takes.")
        .def("factor", [](const Symbolic& self, Data values) {
            if (Index(values.size()) != self.entries) throw std::invalid_argument("values are not those of the pattern");
            return unlocked([&] { return new Factor(self, {values.data(), Index(values.size())}); });
        }, "values"_a, nb::keep_alive<0, 1>(),
             "Factor a matrix, given by the values of the lower triangle; of blocks, by those of the upper one by "
             "rows, whole on the diagonal.");
}
