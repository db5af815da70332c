// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "mpm_solver/points/material_points.hpp"

namespace gabion::mpm {

/// Whether the sides of a body's cell meet at right angles, to 1e-6.
template <int dim>
bool is_rectangular(const PointLayout<dim>& layout, std::int32_t cell);

/// The same of the cell that a point was laid in.
/// @param number  of the point in its body
template <int dim>
bool lies_in_rectangle(const PointLayout<dim>& layout, std::int64_t number);

}  // namespace gabion::mpm
