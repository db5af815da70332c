// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <limits>
#include <span>
#include <string>
#include <vector>

#include "common/mechanics/tensor.hpp"
#include "common/settings/config_reader.hpp"
#include "common/settings/time_function.hpp"

namespace gabion::mpm {

/// Free water at rest beside and over the soil, in a range of x. Its level may change in time.
struct Pool {
  double from = -std::numeric_limits<double>::infinity();  ///< x where it begins [m]
  double to = std::numeric_limits<double>::infinity();     ///< x where it ends [m]
  TimeFunction level = TimeFunction::constant(0);          ///< [m]
};

KeyTable pool_keys();

/// Read "pools".
/// @returns none, or ranges that follow each other with gaps between them, from -infinity to
///          infinity
/// @throws ConfigError
std::vector<Pool> read_pools(ConfigReader& in);

/// Pools at an instant. Between their ranges the level is interpolated, and the pressure is
///
///     p(x) = rho_w g <level(x) - height> ,
///
/// a continuous function of the place.
class PoolLevels {
 public:
  PoolLevels() = default;  ///< no pool
  /// @param specific_weight  rho_w g [N/m^3]
  PoolLevels(std::span<const Pool> pools, double time, double specific_weight);

  bool empty() const { return ranges_.empty(); }
  double level(double x) const;  ///< [m]; @pre not empty
  double slope(double x) const;  ///< of the level; @pre not empty
  /// Places where the slope changes, ascending [m].
  const std::vector<double>& bends() const { return bends_; }

  /// rho_w g (level - height): the pressure, negative above the level [Pa]. @pre not empty
  template <int dim>
  double signed_pressure(const Vector<dim>& x) const {
    return weight_ * (level(x[0]) - x[dim - 1]);
  }
  /// Pressure at a place, 0 without pools [Pa].
  template <int dim>
  double pressure(const Vector<dim>& x) const {
    return empty() ? 0 : std::max(0.0, signed_pressure<dim>(x));
  }
  /// Gradient of the pressure, 0 above the level [Pa/m].
  template <int dim>
  Vector<dim> gradient(const Vector<dim>& x) const {
    Vector<dim> result = Vector<dim>::Zero();
    if (empty() || signed_pressure<dim>(x) <= 0) return result;
    result[0] = weight_ * slope(x[0]);
    result[dim - 1] -= weight_;
    return result;
  }

 private:
  struct Range {
    double from, to, level;
  };
  std::size_t range_of(double x) const;  // the last one that begins at x or before, or the first

  std::vector<Range> ranges_;
  std::vector<double> bends_;
  double weight_ = 0;
};

}  // namespace gabion::mpm
