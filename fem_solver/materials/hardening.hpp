// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

namespace gabion::fem {

/// Plastic strain of a step, and the slope of the yield stress where it ends [Pa].
struct PlasticFlow {
  double strain = 0;
  double slope = 0;
};

/// Yield stress of uniaxial tension over equivalent plastic strain p: rows, linear between them.
class Hardening {
 public:
  /// @param modulus  slope of the yield stress [Pa], >= 0
  static Hardening linear(double yield_stress, double modulus);
  /// Flat after the last row.
  /// @param strains   from 0 on, rising
  /// @param stresses  as many, > 0, not falling [Pa]
  static Hardening table(std::vector<double> strains, std::vector<double> stresses);

  double yield_stress(double p) const;  ///< [Pa]
  /// Integral of the yield stress from 0 to p [J/m^3].
  double work(double p) const;
  /// The dp > 0 of q - stiffness dp - yield_stress(p + dp) = 0, row by row.
  /// @pre q > yield_stress(p), stiffness > 0
  PlasticFlow flow(double q, double p, double stiffness) const;

 private:
  std::size_t row_at(double p) const;
  double slope_of(std::size_t row) const;

  std::vector<double> strains_{0}, stresses_{0};
  double last_slope_ = 0;  // [Pa]
};

}  // namespace gabion::fem
