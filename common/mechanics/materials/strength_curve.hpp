// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

namespace gabion {

/// Strength of a soil after some shear, or its derivative by what measures the shear.
struct Strength {
  double cohesion = 0;      ///< [Pa]
  double sin_friction = 0;  ///< sin phi
  double sin_dilation = 0;  ///< sin psi
};

/// Law by which the dilation decays.
enum class Dilation {
  exponential,  ///< with the strength
  rowe  ///< sin psi = (sin phi - sin phi_cv) / (1 - sin phi sin phi_cv), phi_cv the residual
};

/// Exponential loss, or gain, of strength with the shear x,
///
///     c = c_m + (c_r - c_m) exp(-x / x_m) + (c_p - c_r) exp(-x / x_c) ,
///     sin phi = sin phi_r + (sin phi_p - sin phi_r) exp(-x / x_c)
///
/// from the peak p to the residual r and, if x_m > 0, on to the remoulded m.
struct ExponentialCurve {
  Strength peak = {}, residual = {};  ///< the dilation of the residual is not used
  double scale = 0;                   ///< x_c > 0
  double remoulded_cohesion = 0;
  double remoulding_scale = 0;  ///< x_m; 0: nothing is remoulded
  Dilation dilation = Dilation::exponential;
};

/// Strength at x = 0 < x_1 < ..., between them monotone cubics (Fritsch and Carlson 1980), constant
/// beyond the last.
struct TabulatedCurve {
  std::vector<double> x = {};
  std::vector<Strength> values = {};
};

/// Strength of a soil by the shear x >= 0 that it has seen, in a unit of the curve's own.
class StrengthCurve {
 public:
  struct Point {
    Strength value, slope;
  };

  StrengthCurve() = default;
  explicit StrengthCurve(const ExponentialCurve& curve) : exponential_(curve) {}
  /// @pre x ascends from 0, two entries at least
  explicit StrengthCurve(const TabulatedCurve& curve);

  Point at(double x) const { return table_.x.empty() ? exponential_at(x) : table_at(x); }
  /// Shears at which to look for an extremum: from 0 to where nothing changes any more.
  std::vector<double> samples() const;

 private:
  Point exponential_at(double x) const;
  Point table_at(double x) const;

  ExponentialCurve exponential_;
  TabulatedCurve table_;
  std::vector<Strength> slopes_;  // of the table
};

}  // namespace gabion
