// How arrays of NumPy come in without a copy, and go out owned. The only header that knows Python, for bindings.
#pragma once
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include <complex>

#include "arrays.hpp"

namespace nb = nanobind;
using namespace nb::literals;

// Arguments. Those of const T are converted where their type or layout differs; others need .noconvert(), or the
// loops would fill a copy.
template <class T>
using In1 = nb::ndarray<T, nb::ndim<1>, nb::c_contig, nb::device::cpu>;
template <class T>
using In2 = nb::ndarray<T, nb::ndim<2>, nb::c_contig, nb::device::cpu>;

template <class T>
View<T> view(const In1<T>& a) {
    return {a.data(), Index(a.shape(0))};
}
template <class T>
Matrix<T> matrix(const In2<T>& a) {
    return {a.data(), Index(a.shape(0)), Index(a.shape(1))};
}

// Results.
template <class T>
using Out1 = nb::ndarray<nb::numpy, T, nb::ndim<1>>;
template <class T>
using Out2 = nb::ndarray<nb::numpy, T, nb::ndim<2>>;

template <class T>
Out1<T> out(Array<T>&& a) {
    const std::size_t size = a.size();
    T* data = a.release();
    return {data, {size}, nb::capsule(data, [](void* p) noexcept { delete[] static_cast<T*>(p); })};
}
template <class T>
Out2<T> out2(Array<T>&& a) {
    const std::size_t rows = a.rows, columns = a.columns;
    T* data = a.release();
    return {data, {rows, columns}, nb::capsule(data, [](void* p) noexcept { delete[] static_cast<T*>(p); })};
}
template <class T>
Out1<T> out(std::vector<T>&& v) {
    auto* held = new std::vector<T>(std::move(v));
    return {held->data(), {held->size()},
            nb::capsule(held, [](void* p) noexcept { delete static_cast<std::vector<T>*>(p); })};
}
template <class T>
Out2<T> out2(std::vector<T>&& v, Index columns) {
    auto* held = new std::vector<T>(std::move(v));
    return {held->data(), {held->size() / std::size_t(columns), std::size_t(columns)},
            nb::capsule(held, [](void* p) noexcept { delete static_cast<std::vector<T>*>(p); })};
}

// Call loops without Python's lock.
template <class Loops>
auto unlocked(const Loops& loops) {
    nb::gil_scoped_release lock;
    return loops();
}

// The bindings of each unit.
void bind_cholesky(nb::module_&);
void bind_angles(nb::module_&);
void bind_graphs(nb::module_&);
void bind_overlaps(nb::module_&);
void bind_packing(nb::module_&);
