// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "common/mechanics/tensor.hpp"

namespace gabion::mpm {

/// A material point at which the soil ends in air.
template <int dim>
struct OuterPoint {
  std::int32_t point = 0;
  Vector<dim> n = Vector<dim>::Zero();  ///< unit, out of the soil
  double R = 0;                         ///< distance of the surface along n [m]
  double area = 0;                      ///< [m^2] (2D: per metre of thickness)
};

}  // namespace gabion::mpm
