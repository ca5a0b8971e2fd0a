// Arrays as the loops see them: views of what belongs to the caller, and arrays that go out.
#pragma once
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <tuple>
#include <utility>
#include <vector>

using Index = std::int64_t;

constexpr double PI = 3.14159265358979323846;

// Tells the compiler that a loop's iterations do not depend on each other through memory.
#if defined(__clang__)
#define INDEPENDENT _Pragma("clang loop vectorize(assume_safety)")
#elif defined(__GNUC__)
#define INDEPENDENT _Pragma("GCC ivdep")
#else
#define INDEPENDENT __pragma(loop(ivdep))
#endif

// A row of numbers that belongs to somebody else.
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

    T& operator[](Index i) const { return data[i]; }
    T* begin() const { return data; }
    T* end() const { return data + size; }
    View part(Index first, Index last) const { return {data + first, last - first}; }
};

// The same with rows, one after the other.
template <class T>
struct Matrix {
    T* data = nullptr;
    Index rows = 0, columns = 0;

    T* operator[](Index i) const { return data + i * columns; }
    operator Matrix<const T>() const { return {data, rows, columns}; }
};

// An array that is not filled at first and goes out to the caller.
template <class T>
class Array {
    std::unique_ptr<T[]> held;

  public:
    Index rows = 0, columns = 1;

    Array() = default;
    explicit Array(Index rows, Index columns = 1) : held(new T[rows * columns]), rows(rows), columns(columns) {}

    T* data() const { return held.get(); }
    Index size() const { return rows * columns; }
    T& operator[](Index i) const { return held[i]; }
    View<T> view() const { return {held.get(), size()}; }
    Matrix<T> matrix() const { return {held.get(), rows, columns}; }
};

// The same, which goes out with rows and columns.
template <class T>
struct Grid : Array<T> {
    using Array<T>::Array;
};

// And in square layers, one after the other.
template <class T>
struct Squares : Array<T> {
    using Array<T>::Array;
};

template <class T>
Array<T> filled(Index size, T value) {
    Array<T> made(size);
    std::fill_n(made.data(), size, value);
    return made;
}

// A complex number, or a place in the plane: as std::complex is in memory, which some compilers keep there.
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
