// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "common/settings/scene.hpp"
#include "fem_solver/matrices/linear_model.hpp"
#include "fem_solver/matrices/matrix_settings.hpp"

namespace gabion::fem {

/// A structure as its files describe it.
template <int dim>
struct MatrixStructure {
  LinearModel model;     ///< held unknowns are taken out
  Eigen::VectorXd load;  ///< constant forces on its unknowns [N]
  /// Nodes of "nodes" in the order of that file; cells of "cells", else none; facet groups by the
  /// names of their files.
  Mesh<dim> mesh;
  std::vector<std::int64_t> node_numbers;  ///< of the mesh's nodes, as in the files
  /// Unknown of each component of the displacement of each node, num_nodes x dim; -1: held.
  std::vector<std::int32_t> unknown_of;
};

/// @throws ConfigError  file and line, or place in fem.json: sizes that differ, a matrix that is
/// not
///                      symmetric, an unknown or node that is not there or there twice
template <int dim>
MatrixStructure<dim> read_matrix_structure(const Scene& scene, const MatrixSettings<dim>& settings);

}  // namespace gabion::fem
