// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

namespace gabion::fem {

/// A part of a section with one stress.
struct Fibre {
  double y = 0, z = 0;  ///< along axes 2 and 3 [m]
  double area = 0;      ///< [m^2]
};

/// Fibres at points of Gauss, so that area and second moments are those of the section, and the
/// plastic moment of a rectangle is, too.
/// @param height  along axis 2 [m]
/// @param width   along axis 3 [m]
/// @param dim     2: layers across axis 2 alone
std::vector<Fibre> rectangle_fibres(double height, double width, int dim);
/// @param inner  diameter [m], 0: solid
std::vector<Fibre> ring_fibres(double diameter, double inner);

}  // namespace gabion::fem
