// Conversion between views and NumPy arrays.
// Arguments are not copied, and results own their memory.
// This is the only header that depends on Python.
#pragma once
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/array.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/unique_ptr.h>
#include <nanobind/stl/vector.h>

#include <complex>

#include "arrays.hpp"
#include "shapes.hpp"

namespace nb = nanobind;
using namespace nb::literals;

// The element type of the NumPy array for a view of T.
// It is T itself if T is a number; a struct becomes a row of indices.
template <class T>
struct Items {
    using Scalar = std::conditional_t<std::is_arithmetic_v<T>, T, Index>;
};
template <class T>
struct Items<const T> {
    using Scalar = const typename Items<T>::Scalar;
};
template <class T, std::size_t N>
struct Items<std::array<T, N>> {
    using Scalar = T;
};
template <>
struct Items<Complex> {
    using Scalar = std::complex<double>;
};
template <class T>
using Scalar = typename Items<T>::Scalar;
template <class T>
constexpr std::size_t SCALARS_PER_ITEM = sizeof(T) / sizeof(Scalar<T>);

// The type of array arguments. nanobind copies an array that has another type or layout.
// Therefore, output arguments need .noconvert().
template <class T, class Shape>
using InputArray = nb::ndarray<Scalar<T>, Shape, nb::c_contig, nb::device::cpu>;

template <class A>
struct Argument {
    using Type = A;
    static A to_view(const A& a) { return a; }
    static void check(const A& a, ShapeRules::Call& shapes) {
        if constexpr (std::is_integral_v<A>) shapes.check({Index(a)});
        else shapes.check({});
    }
};
template <class T>
struct Argument<View<T>> {
    using Shape = std::conditional_t<SCALARS_PER_ITEM<T> == 1, nb::ndim<1>, nb::shape<-1, SCALARS_PER_ITEM<T>>>;
    using Type = InputArray<T, Shape>;
    static View<T> to_view(const Type& a) { return {reinterpret_cast<T*>(a.data()), Index(a.shape(0))}; }
    static void check(const Type& a, ShapeRules::Call& shapes) { shapes.check({Index(a.shape(0))}); }
};
template <class T>
struct Argument<Matrix<T>> {
    using Type = InputArray<T, nb::ndim<2>>;
    static Matrix<T> to_view(const Type& a) {
        return {reinterpret_cast<T*>(a.data()), Index(a.shape(0)), Index(a.shape(1))};
    }
    static void check(const Type& a, ShapeRules::Call& shapes) {
        shapes.check({Index(a.shape(0)), Index(a.shape(1))});
    }
};
template <class T>
struct Argument<std::array<View<T>, 3>> {
    using One = Argument<View<T>>;
    using Type = std::array<typename One::Type, 3>;
    static std::array<View<T>, 3> to_view(const Type& a) {
        return {One::to_view(a[0]), One::to_view(a[1]), One::to_view(a[2])};
    }
    static void check(const Type&, ShapeRules::Call& shapes) { shapes.check({}); }
};

// Convert a container to a NumPy array, which takes ownership of the container.
template <class Owner, class... Shape>
auto to_numpy(Owner&& a, Shape... shape) {
    using N = Scalar<std::remove_pointer_t<decltype(a.data())>>;
    auto owner = std::make_unique<Owner>(std::move(a));
    N* const data = reinterpret_cast<N*>(owner->data());
    const nb::capsule capsule(owner.get(), [](void* p) noexcept { delete static_cast<Owner*>(p); });
    owner.release();
    nb::ndarray<nb::numpy, N, nb::ndim<sizeof...(Shape)>> result(data, {std::size_t(shape)...}, capsule);
    if constexpr (std::is_same_v<N, Index>) // NumPy has two 64-bit integer types, and one is not printed as int64
        return nb::object(nb::cast(std::move(result)).attr("view")(nb::module_::import_("numpy").attr("int64")));
    else return result;
}

template <class T, class = std::enable_if_t<std::is_arithmetic_v<T>>>
T to_result(T number) {
    return number;
}
template <class T>
auto to_result(Array<T>&& a) {
    return to_numpy(std::move(a), a.size());
}
template <class T>
auto to_result(Grid<T>&& a) {
    return to_numpy(std::move(a), a.rows, a.columns);
}
template <class T>
auto to_result(Squares<T>&& a) {
    return to_numpy(std::move(a), a.columns ? a.rows / a.columns : 0, a.columns, a.columns);
}
template <class T>
auto to_result(std::vector<T>&& v) {
    if constexpr (SCALARS_PER_ITEM<T> == 1) return to_numpy(std::move(v), v.size());
    else return to_numpy(std::move(v), v.size(), SCALARS_PER_ITEM<T>);
}
inline auto to_result(std::vector<std::vector<Index>>&& lists) { return std::move(lists); }
template <class... T>
auto to_result(std::tuple<T...>&& all) {
    return std::apply([](auto&... each) { return std::tuple(to_result(std::move(each))...); }, all);
}

// A type that converts to any other type, which is used to count the fields of a struct.
struct AnyField {
    template <class T>
    operator T() const;
};
template <class S, class = void, class... AnyFields>
constexpr bool HAS_FIELDS = false;
template <class S, class... AnyFields>
constexpr bool HAS_FIELDS<S, std::void_t<decltype(S{AnyFields()...})>, AnyFields...> = true;

// Convert a struct of results to a tuple.
template <class S, class = std::enable_if_t<std::is_aggregate_v<S>>>
auto to_result(S&& s) {
    if constexpr (HAS_FIELDS<S, void, AnyField, AnyField, AnyField, AnyField>) {
        auto& [a, b, c, d] = s;
        return std::tuple(to_result(std::move(a)), to_result(std::move(b)), to_result(std::move(c)),
                          to_result(std::move(d)));
    } else if constexpr (HAS_FIELDS<S, void, AnyField, AnyField, AnyField>) {
        auto& [a, b, c] = s;
        return std::tuple(to_result(std::move(a)), to_result(std::move(b)), to_result(std::move(c)));
    } else {
        auto& [a, b] = s;
        return std::tuple(to_result(std::move(a)), to_result(std::move(b)));
    }
}

// Call a function without holding the GIL.
template <class Loops>
auto without_gil(const Loops& loops) {
    nb::gil_scoped_release lock;
    return loops();
}

// Wrap a function of views as a function of NumPy arrays. `shapes` are the `ShapeRules` of its arguments.
template <class R, class... A>
auto wrap(R (*loops)(A...), const char* shapes) {
    return [loops, rules = ShapeRules(shapes, sizeof...(A))](const typename Argument<A>::Type&... a) {
        ShapeRules::Call call(rules);
        (Argument<A>::check(a, call), ...);
        const auto run = [&] { return loops(Argument<A>::to_view(a)...); };
        if constexpr (std::is_void_v<R>) without_gil(run);
        else return to_result(without_gil(run));
    };
}
