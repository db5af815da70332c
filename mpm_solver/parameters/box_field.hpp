// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <string>
#include <vector>

#include "common/mechanics/tensor.hpp"

namespace gabion::mpm {

/// Values at the nodes of a lattice along the axes.
template <int dim>
struct BoxField {
  std::string path;
  std::array<std::vector<double>, dim> axes{};  ///< ascending coordinates of the nodes [m]
  std::vector<double> values{};                 ///< the last axis fastest

  /// Linear along each axis between the nodes.
  /// @throws ConfigError  outside of these, or a value it needs is no number
  double at(const Vector<dim>& x) const;
};

/// Read an HDF5 file with the coordinates of the nodes in the datasets "x", "y" and in 3D "z", and
/// "values" of the shape [x, y] or [x, y, z]; real numbers or integers.
/// @throws ConfigError  names file and dataset
template <int dim>
BoxField<dim> read_box_field(const std::string& path);

}  // namespace gabion::mpm
