// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cmath>
#include <cstddef>

#include "fem_solver/beams/dual.hpp"

namespace gabion::fem {

/// Three numbers or duals.
template <class S>
using Triple = std::array<S, 3>;

template <class S>
Triple<S> operator+(const Triple<S>& a, const Triple<S>& b) {
  return {a[0] + b[0], a[1] + b[1], a[2] + b[2]};
}
template <class S>
Triple<S> operator-(const Triple<S>& a, const Triple<S>& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
template <class S>
Triple<S> operator*(const S& s, const Triple<S>& a) {
  return {s * a[0], s * a[1], s * a[2]};
}
template <class S>
S dot(const Triple<S>& a, const Triple<S>& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
template <class S>
Triple<S> cross(const Triple<S>& a, const Triple<S>& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

/// Functions of x = |t|^2 that are smooth at 0; there they are series.
namespace turn_series {

inline constexpr double end = 0.1;  ///< six terms give all digits below

template <class S, std::size_t n>
S sum(const S& x, const std::array<double, n>& terms) {
  S result = terms[n - 1];
  for (std::size_t k = n - 1; k-- > 0;) result = result * x + S(terms[k]);
  return result;
}

/// cos t
template <class S>
S cosine(const S& x) {
  using std::cos, std::sqrt;
  if (value_of(x) < end) {
    return sum<S, 7>(
        x, {1.0, -1.0 / 2, 1.0 / 24, -1.0 / 720, 1.0 / 40320, -1.0 / 3628800, 1.0 / 479001600});
  }
  return cos(sqrt(x));
}

/// sin t / t
template <class S>
S sine(const S& x) {
  using std::sin, std::sqrt;
  if (value_of(x) < end) {
    return sum<S, 7>(x, {1.0, -1.0 / 6, 1.0 / 120, -1.0 / 5040, 1.0 / 362880, -1.0 / 39916800,
                         1.0 / 6227020800});
  }
  const S t = sqrt(x);
  return sin(t) / t;
}

/// (1 - cos t) / t^2
template <class S>
S second(const S& x) {
  if (value_of(x) < end) {
    return sum<S, 7>(x, {1.0 / 2, -1.0 / 24, 1.0 / 720, -1.0 / 40320, 1.0 / 3628800,
                         -1.0 / 479001600, 1.0 / 87178291200});
  }
  return (S(1.0) - cosine(x)) / x;
}

/// (t - sin t) / t^3
template <class S>
S third(const S& x) {
  if (value_of(x) < end) {
    return sum<S, 7>(x, {1.0 / 6, -1.0 / 120, 1.0 / 5040, -1.0 / 362880, 1.0 / 39916800,
                         -1.0 / 6227020800, 1.0 / 1307674368000});
  }
  return (S(1.0) - sine(x)) / x;
}

/// [1 - t / 2 cot(t / 2)] / t^2
template <class S>
S inverse(const S& x) {
  using std::cos, std::sin, std::sqrt;
  if (value_of(x) < end) {
    return sum<S, 7>(x, {1.0 / 12, 1.0 / 720, 1.0 / 30240, 1.0 / 1209600, 1.0 / 47900160,
                         691.0 / 1307674368000, 1.0 / 74724249600});
  }
  const S half = S(0.5) * sqrt(x);
  return (S(1.0) - half * cos(half) / sin(half)) / x;
}

}  // namespace turn_series

/// A rotation as a unit quaternion.
template <class S>
struct Turn {
  S w = 1.0;
  Triple<S> v = {};
};

/// The rotation b followed by a.
template <class S>
Turn<S> operator*(const Turn<S>& a, const Turn<S>& b) {
  return {a.w * b.w - dot(a.v, b.v), a.w * b.v + b.w * a.v + cross(a.v, b.v)};
}
template <class S>
Turn<S> inverse(const Turn<S>& a) {
  return {a.w, S(-1.0) * a.v};
}
template <class S>
Triple<S> rotate(const Turn<S>& a, const Triple<S>& x) {
  const Triple<S> t = S(2.0) * cross(a.v, x);
  return x + a.w * t + cross(a.v, t);
}

/// Rotation about the direction of t by the angle |t|.
template <class S>
Turn<S> turn_by(const Triple<S>& t) {
  const S quarter = S(0.25) * dot(t, t);  // square of half the angle
  return {turn_series::cosine(quarter), S(0.5) * turn_series::sine(quarter) * t};
}

/// The t of turn_by(), |t| <= pi.
template <class S>
Triple<S> vector_of(const Turn<S>& a) {
  using std::atan2, std::sqrt;
  const S sign = value_of(a.w) < 0 ? -1.0 : 1.0;
  const S s2 = dot(a.v, a.v), w = sign * a.w;  // sine and cosine of half the angle
  if (value_of(s2) < 0.01) {
    // asin(s) / s
    const S ratio = turn_series::sum<S, 8>(s2, {1.0, 1.0 / 6, 3.0 / 40, 5.0 / 112, 35.0 / 1152,
                                                63.0 / 2816, 231.0 / 13312, 143.0 / 10240});
    return S(2.0) * sign * ratio * a.v;
  }
  const S s = sqrt(s2);
  return S(2.0) * sign * atan2(s, w) / s * a.v;
}

/// T(t)^T x, with which a spin is T(t) dt: T = 1 + a [t] + b [t]^2 (docs/theory/structure.md).
template <class S>
Triple<S> transposed_spin(const Triple<S>& t, const Triple<S>& x) {
  const S square = dot(t, t);
  const Triple<S> tx = cross(t, x);
  return x - turn_series::second(square) * tx + turn_series::third(square) * cross(t, tx);
}

/// T(t)^-T x; T^-1 = 1 - [t] / 2 + c [t]^2.
template <class S>
Triple<S> transposed_inverse_spin(const Triple<S>& t, const Triple<S>& x) {
  const Triple<S> tx = cross(t, x);
  return x + S(0.5) * tx + turn_series::inverse(dot(t, t)) * cross(t, tx);
}

}  // namespace gabion::fem
