// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>

#include "common/mechanics/mesh/mesh.hpp"

namespace gabion {

/// Box along the axes around the nodes of a mesh [m]; empty without nodes.
template <int dim>
Eigen::AlignedBox<double, dim> box_around(const Mesh<dim>& mesh) {
  Eigen::AlignedBox<double, dim> box;
  for (const Vector<dim>& x : mesh.nodes) box.extend(x);
  return box;
}

}  // namespace gabion
