// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cmath>
#include <type_traits>

namespace gabion::fem {

/// A number and its derivatives by n others: arithmetic on these differentiates a formula.
template <int n>
struct Dual {
  double value = 0;
  std::array<double, n> slope = {};

  Dual() = default;
  Dual(double constant) : value(constant) {}  // NOLINT(google-explicit-constructor)

  /// f(value), whose derivative there is df.
  Dual chain(double f, double df) const {
    Dual result(f);
    for (int i = 0; i < n; ++i) result.slope[i] = df * slope[i];
    return result;
  }

  friend Dual operator+(const Dual& a, const Dual& b) { return sum(a, 1, b, 1, a.value + b.value); }
  friend Dual operator-(const Dual& a, const Dual& b) {
    return sum(a, 1, b, -1, a.value - b.value);
  }
  friend Dual operator-(const Dual& a) { return a.chain(-a.value, -1); }
  friend Dual operator*(const Dual& a, const Dual& b) {
    return sum(a, b.value, b, a.value, a.value * b.value);
  }
  friend Dual operator/(const Dual& a, const Dual& b) {
    const double ratio = a.value / b.value;
    return sum(a, 1 / b.value, b, -ratio / b.value, ratio);
  }
  friend Dual sqrt(const Dual& a) {
    const double root = std::sqrt(a.value);
    return a.chain(root, 0.5 / root);
  }
  friend Dual sin(const Dual& a) { return a.chain(std::sin(a.value), std::cos(a.value)); }
  friend Dual cos(const Dual& a) { return a.chain(std::cos(a.value), -std::sin(a.value)); }
  friend Dual atan2(const Dual& y, const Dual& x) {
    const double square = x.value * x.value + y.value * y.value;
    return sum(y, x.value / square, x, -y.value / square, std::atan2(y.value, x.value));
  }

 private:
  /// A value and the slopes s a' + t b'.
  static Dual sum(const Dual& a, double s, const Dual& b, double t, double value) {
    Dual result(value);
    for (int i = 0; i < n; ++i) result.slope[i] = s * a.slope[i] + t * b.slope[i];
    return result;
  }
};

/// The i-th unknown: a number, or one that derivatives are taken by.
template <class S>
S unknown(double value, int i) {
  S x = value;
  if constexpr (!std::is_same_v<S, double>) x.slope[i] = 1;
  return x;
}

inline double value_of(double x) {
  return x;
}
template <int n>
double value_of(const Dual<n>& x) {
  return x.value;
}

}  // namespace gabion::fem
