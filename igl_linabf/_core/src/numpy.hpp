// How functions on views become functions on arrays of NumPy, which come in without a copy and go out owned. The only
// header that knows Python, for bindings.
#pragma once
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/array.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include <complex>

#include "arrays.hpp"

namespace nb = nanobind;
using namespace nb::literals;

// What NumPy has where a T is here: a number, or a row of the numbers of a struct, which are indices.
template <class T>
struct Items {
    using Number = std::conditional_t<std::is_arithmetic_v<T>, T, Index>;
};
template <class T>
struct Items<const T> {
    using Number = const typename Items<T>::Number;
};
template <class T, std::size_t N>
struct Items<std::array<T, N>> {
    using Number = T;
};
template <>
struct Items<Complex> {
    using Number = std::complex<double>;
};
template <class T>
using Number = typename Items<T>::Number;
template <class T>
constexpr std::size_t IN_A_ROW = sizeof(T) / sizeof(Number<T>);

// Arguments. Arrays of const T are converted where their type or layout differs; others need .noconvert(), or the loops
// would fill a copy.
template <class T, class Shape>
using In = nb::ndarray<Number<T>, Shape, nb::c_contig, nb::device::cpu>;

template <class A>
struct Argument {
    using Type = A;
    static A in(const A& a) { return a; }
};
template <class T>
struct Argument<View<T>> {
    using Type = In<T, std::conditional_t<IN_A_ROW<T> == 1, nb::ndim<1>, nb::shape<-1, IN_A_ROW<T>>>>;
    static View<T> in(const Type& a) { return {reinterpret_cast<T*>(a.data()), Index(a.shape(0))}; }
};
template <class T>
struct Argument<Matrix<T>> {
    using Type = In<T, nb::ndim<2>>;
    static Matrix<T> in(const Type& a) {
        return {reinterpret_cast<T*>(a.data()), Index(a.shape(0)), Index(a.shape(1))};
    }
};
template <class T>
struct Argument<std::array<View<T>, 3>> {
    using One = Argument<View<T>>;
    using Type = std::array<typename One::Type, 3>;
    static std::array<View<T>, 3> in(const Type& a) { return {One::in(a[0]), One::in(a[1]), One::in(a[2])}; }
};

// Results. An array of NumPy of this shape owns what holds the numbers.
template <class Held, class... Shape>
auto owned(Held&& a, Shape... shape) {
    using N = Number<std::remove_pointer_t<decltype(a.data())>>;
    auto* const held = new Held(std::move(a));
    nb::ndarray<nb::numpy, N, nb::ndim<sizeof...(Shape)>> made(
        reinterpret_cast<N*>(held->data()), {std::size_t(shape)...},
        nb::capsule(held, [](void* p) noexcept { delete static_cast<Held*>(p); }));
    if constexpr (std::is_same_v<N, Index>) // NumPy has two types of 64 bits; the one that is not int64 prints so
        return nb::object(nb::cast(std::move(made)).attr("view")(nb::module_::import_("numpy").attr("int64")));
    else return made;
}

template <class T, class = std::enable_if_t<std::is_arithmetic_v<T>>>
T result(T number) {
    return number;
}
template <class T>
auto result(Array<T>&& a) {
    return owned(std::move(a), a.size());
}
template <class T>
auto result(Grid<T>&& a) {
    return owned(std::move(a), a.rows, a.columns);
}
template <class T>
auto result(Squares<T>&& a) {
    return owned(std::move(a), a.columns ? a.rows / a.columns : 0, a.columns, a.columns);
}
template <class T>
auto result(std::vector<T>&& v) {
    if constexpr (IN_A_ROW<T> == 1) return owned(std::move(v), v.size());
    else return owned(std::move(v), v.size(), IN_A_ROW<T>);
}
inline auto result(std::vector<std::vector<Index>>&& lists) { return std::move(lists); }
template <class... T>
auto result(std::tuple<T...>&& all) {
    return std::apply([](auto&... each) { return std::tuple(result(std::move(each))...); }, all);
}

// A struct of these is a tuple. A Field is any one of a struct's, to count them.
struct Field {
    template <class T>
    operator T() const;
};
template <class S, class = void, class... Fields>
constexpr bool HAS = false;
template <class S, class... Fields>
constexpr bool HAS<S, std::void_t<decltype(S{Fields()...})>, Fields...> = true;

template <class S, class = std::enable_if_t<std::is_aggregate_v<S>>>
auto result(S&& s) {
    if constexpr (HAS<S, void, Field, Field, Field, Field>) {
        auto& [a, b, c, d] = s;
        return std::tuple(result(std::move(a)), result(std::move(b)), result(std::move(c)), result(std::move(d)));
    } else if constexpr (HAS<S, void, Field, Field, Field>) {
        auto& [a, b, c] = s;
        return std::tuple(result(std::move(a)), result(std::move(b)), result(std::move(c)));
    } else {
        auto& [a, b] = s;
        return std::tuple(result(std::move(a)), result(std::move(b)));
    }
}

// Call loops without Python's lock.
template <class Loops>
auto unlocked(const Loops& loops) {
    nb::gil_scoped_release lock;
    return loops();
}

template <class R, class... A>
auto bound(R (*loops)(A...)) {
    return [loops](const typename Argument<A>::Type&... a) {
        const auto run = [&] { return loops(Argument<A>::in(a)...); };
        if constexpr (std::is_void_v<R>) unlocked(run);
        else return result(unlocked(run));
    };
}
