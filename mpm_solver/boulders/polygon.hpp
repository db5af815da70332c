// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "common/mechanics/tensor.hpp"

namespace gabion::mpm {

/// Corners of a closed polygon in order, the last side goes back to the first corner [m].
using Polygon = std::vector<Vector<2>>;

/// Area [m^2], below 0 where the corners go clockwise.
double signed_area(const Polygon& polygon);

bool is_inside(const Polygon& polygon, const Vector<2>& x);

/// Distance of a point from the nearest side [m].
double distance_to(const Polygon& polygon, const Vector<2>& x);

/// @throws ConfigError  a corner stands twice in a row, or two sides meet elsewhere than in a
/// corner
///                      that they share: which, where
void require_simple(const Polygon& polygon);

}  // namespace gabion::mpm
