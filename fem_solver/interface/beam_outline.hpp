// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "fem_solver/fem_config.hpp"

namespace gabion::fem {

/// Sections at the nodes of beams, and the facets between them.
template <int dim>
struct BeamOutline {
  std::vector<std::int32_t> nodes;   ///< of the mesh, one a vertex
  std::vector<Vector<dim>> offsets;  ///< from the node, before loading [m]
  std::vector<std::int64_t> facets;  ///< vertices, 2 or 4 a facet, normals outward
};

/// Outline of the beams of some groups, whether those of a group are connected or not.
/// @throws ConfigError  see BeamSurfaces
template <int dim>
BeamOutline<dim> beam_outline(const FemSettings<dim>& settings,
                              const std::vector<std::string>& groups, const std::string& where);

}  // namespace gabion::fem
