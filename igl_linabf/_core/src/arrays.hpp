// Array types of the core: non-owning views of the caller's arrays, and owning arrays for results.
#pragma once
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <stdexcept>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

using Index = std::int64_t;

constexpr double PI = 3.14159265358979323846;

// Tell the compiler that the iterations of a loop do not depend on each other through memory.
#if defined(__clang__)
#define INDEPENDENT _Pragma("clang loop vectorize(assume_safety)")
#elif defined(__GNUC__)
#define INDEPENDENT _Pragma("GCC ivdep")
#else
#define INDEPENDENT __pragma(loop(ivdep))
#endif

// SIMD vectorizes a short loop as a whole instead of unrolling it.
// SUMS_OF vectorizes a loop that adds to the given variables, which changes the order of the additions.
#define PRAGMA(text) _Pragma(#text)
#if defined(__clang__) || defined(__GNUC__)
#define SIMD PRAGMA(omp simd)
#define SUMS_OF(...) PRAGMA(omp simd reduction(+ : __VA_ARGS__))
#else
#define SIMD INDEPENDENT
#define SUMS_OF(...) INDEPENDENT
#endif

// In a checked build, throw if an index is out of range.
#ifdef CHECKED
inline void check_index(Index i, Index size) {
    if (std::uint64_t(i) >= std::uint64_t(size))
        throw std::out_of_range("index " + std::to_string(i) + " of an array of " + std::to_string(size));
}
#else
inline void check_index(Index, Index) {}
#endif

// A non-owning view of a one-dimensional array.
template <class T>
struct View {
    T* data = nullptr;
    Index size = 0;

    View() = default;
    View(T* data, Index size) : data(data), size(size) {}
    View(std::vector<std::remove_const_t<T>>& v) : data(v.data()), size(Index(v.size())) {}
    template <class U, class = std::enable_if_t<std::is_same_v<const U, T>>>
    View(const std::vector<U>& v) : data(v.data()), size(Index(v.size())) {}
    template <class U, class = std::enable_if_t<std::is_same_v<const U, T>>>
    View(const View<U>& v) : data(v.data), size(v.size) {}

    T& operator[](Index i) const {
        check_index(i, size);
        return data[i];
    }
    T* begin() const { return data; }
    T* end() const { return data + size; }
    View part(Index first, Index last) const {
        check_index(first, size + 1), check_index(last - first, size - first + 1);
        return {data + first, last - first};
    }
};

#ifdef CHECKED
template <class T>
struct MatrixRow : View<T> {
    using View<T>::View;
    operator T*() const { return this->data; }
};
#else
template <class T>
using MatrixRow = T*;
#endif

// A non-owning view of a two-dimensional array in row-major order.
template <class T>
struct Matrix {
    T* data = nullptr;
    Index rows = 0, columns = 0;

    MatrixRow<T> operator[](Index i) const {
        check_index(i, rows);
#ifdef CHECKED
        return {data + i * columns, columns};
#else
        return data + i * columns;
#endif
    }
    operator Matrix<const T>() const { return {data, rows, columns}; }
};

// An owning array, whose entries are not initialized. It is returned to Python as a one-dimensional NumPy array.
template <class T>
class Array {
    std::unique_ptr<T[]> storage;

  public:
    Index rows = 0, columns = 1;

    Array() = default;
    explicit Array(Index rows, Index columns = 1) : storage(new T[rows * columns]), rows(rows), columns(columns) {}

    T* data() const { return storage.get(); }
    Index size() const { return rows * columns; }
    T& operator[](Index i) const {
        check_index(i, size());
        return storage[i];
    }
    View<T> view() const { return {storage.get(), size()}; }
    Matrix<T> matrix() const { return {storage.get(), rows, columns}; }
};

// An owning array that is returned to Python as a two-dimensional NumPy array.
template <class T>
struct Grid : Array<T> {
    using Array<T>::Array;
};

// An owning array that is returned to Python as a three-dimensional NumPy array of square layers.
template <class T>
struct Squares : Array<T> {
    using Array<T>::Array;
};

template <class T>
Array<T> full(Index size, T value) {
    Array<T> result(size);
    std::fill_n(result.data(), size, value);
    return result;
}

// A complex number or a point in the plane, with the memory layout of std::complex.
// It replaces std::complex, because some compilers do not keep a std::complex in registers.
struct Complex {
    double x, y;
};

inline Complex operator+(Complex a, Complex b) { return {a.x + b.x, a.y + b.y}; }
inline Complex operator-(Complex a, Complex b) { return {a.x - b.x, a.y - b.y}; }
inline Complex operator*(double s, Complex a) { return {s * a.x, s * a.y}; }
inline Complex operator/(Complex a, double s) { return {a.x / s, a.y / s}; }
inline bool operator==(Complex a, Complex b) { return a.x == b.x && a.y == b.y; }
inline Complex times(Complex a, Complex b) { return {a.x * b.x - a.y * b.y, a.x * b.y + a.y * b.x}; }
inline double dot(Complex a, Complex b) { return a.x * b.x + a.y * b.y; }
inline double cross(Complex a, Complex b) { return a.x * b.y - a.y * b.x; }
inline double length(Complex a) { return std::sqrt(dot(a, a)); }
inline Complex direction(double angle) { return {std::cos(angle), std::sin(angle)}; }
