// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "elastic_solid.hpp"

namespace dealii_structure {

/// A .vtu file for each output, in FOLDER, and FOLDER/frames.pvd with their times for ParaView.
template <int dim>
class Frames {
 public:
  /// Makes the folder. @throws gabion::Error
  explicit Frames(std::string folder);
  /// @param u, v  displacement [m] and velocity [m/s]
  void write(double time, const ElasticSolid<dim>& solid, const Vector& u, const Vector& v);

 private:
  std::string folder_;
  std::vector<std::pair<double, std::string>> written_;  // time [s], file
};

}  // namespace dealii_structure
