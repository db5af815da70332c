// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/mechanics/mesh/mesh.hpp"

namespace gabion {

/// Cells of these groups, ascending, each once. The name "all" stands for all cells, unless a group
/// has it.
/// @throws ConfigError  no such group, with those that exist; `where` says who asks
template <int dim>
std::vector<std::int32_t> cells_of_groups(const Mesh<dim>& mesh,
                                          const std::vector<std::string>& groups,
                                          const std::string& where);

/// Nodes of these cells, ascending, each once.
template <int dim>
std::vector<std::int32_t> nodes_of_cells(const Mesh<dim>& mesh,
                                         const std::vector<std::int32_t>& cells);

}  // namespace gabion
