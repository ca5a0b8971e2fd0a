// How a free function on views becomes one on arrays of NumPy: views from arrays, arrays from results, without Python's
// lock in between.
#pragma once
#include "numpy.hpp"
#include "triangles.hpp"

template <class A>
struct Argument {
    using Type = A;
    static A in(const A& a) { return a; }
};
template <class T>
struct Argument<View<T>> {
    using Type = In1<T>;
    static View<T> in(const Type& a) { return view(a); }
};
template <class T>
struct Argument<Matrix<T>> {
    using Type = In2<T>;
    static Matrix<T> in(const Type& a) { return matrix(a); }
};
template <>
struct Argument<View<const Place>> {
    using Type = In1<const std::complex<double>>;
    static View<const Place> in(const Type& a) { return {reinterpret_cast<const Place*>(a.data()), Index(a.shape(0))}; }
};

inline double result(double a) { return a; }
template <class T>
Out1<T> result(Array<T>&& a) {
    return out(std::move(a));
}
template <class T>
Out2<T> result(Grid<T>&& a) {
    return out2(std::move(a));
}
inline Out1<std::complex<double>> result(Array<Place>&& a) {
    const std::size_t size = a.size();
    Place* data = a.release();
    return {data, {size}, nb::capsule(data, [](void* p) noexcept { delete[] static_cast<Place*>(p); })};
}
template <class... T>
auto result(std::tuple<T...>&& all) {
    return std::apply([](auto&... each) { return std::tuple(result(std::move(each))...); }, all);
}

template <class R, class... A>
auto bound(R (*loops)(A...)) {
    return [loops](const typename Argument<A>::Type&... a) {
        const auto run = [&] { return loops(Argument<A>::in(a)...); };
        if constexpr (std::is_void_v<R>) unlocked(run);
        else return result(unlocked(run));
    };
}
