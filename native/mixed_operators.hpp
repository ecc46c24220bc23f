// Mixed operators for numbers of several doubles, from the other operators; T(d) converts a vector of doubles.
#pragma once

namespace gsp {
namespace {

template <class T>
concept Extended = requires { T::kParts; };

template <Extended T>
INLINE T operator-(const T& a, const T& b) { return a + -b; }
template <Extended T>
INLINE T operator*(double a, const T& b) { return (D{} + a) * b; }
template <Extended T>
INLINE T operator*(const T& a, double b) { return (D{} + b) * a; }
template <Extended T>
INLINE T operator/(double a, const T& b) { return T(D{} + a) / b; }
template <Extended T>
INLINE T operator-(double a, const T& b) { return T(D{} + a) - b; }
template <Extended T>
INLINE T operator+(double a, const T& b) { return T(D{} + a) + b; }
template <Extended T>
INLINE T operator+(const T& a, double b) { return a + T(D{} + b); }
template <Extended T>
INLINE void operator+=(T& a, const T& b) { a = a + b; }
template <Extended T>
INLINE void operator-=(T& a, const T& b) { a = a - b; }

template <Extended T>
INLINE Mask operator>(const T& a, const T& b) { return b < a; }
template <Extended T>
INLINE Mask operator>=(const T& a, const T& b) { return b <= a; }
template <Extended T>
INLINE Mask operator<(const T& a, double b) { return a < T(D{} + b); }
template <Extended T>
INLINE Mask operator<=(const T& a, double b) { return a <= T(D{} + b); }
template <Extended T>
INLINE Mask operator>(const T& a, double b) { return T(D{} + b) < a; }
template <Extended T>
INLINE Mask operator>=(const T& a, double b) { return T(D{} + b) <= a; }

}  // namespace
}  // namespace gsp
