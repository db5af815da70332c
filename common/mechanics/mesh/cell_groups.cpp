// SPDX-License-Identifier: BSD-3-Clause
#include "common/mechanics/mesh/cell_groups.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <numeric>

#include "common/base/error.hpp"

namespace gabion {

namespace {

void sort_once(std::vector<std::int32_t>& numbers) {
  std::ranges::sort(numbers);
  numbers.erase(std::unique(numbers.begin(), numbers.end()), numbers.end());
}

}  // namespace

template <int dim>
std::vector<std::int32_t> cells_of_groups(const Mesh<dim>& mesh,
                                          const std::vector<std::string>& groups,
                                          const std::string& where) {
  std::vector<std::int32_t> cells;
  for (const std::string& group : groups) {
    const auto found = mesh.cell_groups.find(group);
    if (found != mesh.cell_groups.end()) {
      cells.insert(cells.end(), found->second.begin(), found->second.end());
      continue;
    }
    std::vector<std::string> names;
    for (const auto& [name, numbers] : mesh.cell_groups) names.push_back(name);
    if (group != "all") {
      throw ConfigError(fmt::format("{}: found the cell group \"{}\", allowed: all{}{}", where,
                                    group, names.empty() ? "" : ", ", fmt::join(names, ", ")));
    }
    cells.resize(static_cast<std::size_t>(mesh.num_cells()));
    std::iota(cells.begin(), cells.end(), 0);
    return cells;
  }
  sort_once(cells);
  return cells;
}

template <int dim>
std::vector<std::int32_t> nodes_of_cells(const Mesh<dim>& mesh,
                                         const std::vector<std::int32_t>& cells) {
  std::vector<std::int32_t> nodes;
  for (const std::int32_t c : cells) {
    const auto own = mesh.cell(c);
    nodes.insert(nodes.end(), own.begin(), own.end());
  }
  sort_once(nodes);
  return nodes;
}

template std::vector<std::int32_t> cells_of_groups(const Mesh<2>&, const std::vector<std::string>&,
                                                   const std::string&);
template std::vector<std::int32_t> nodes_of_cells(const Mesh<2>&, const std::vector<std::int32_t>&);
template std::vector<std::int32_t> cells_of_groups(const Mesh<3>&, const std::vector<std::string>&,
                                                   const std::string&);
template std::vector<std::int32_t> nodes_of_cells(const Mesh<3>&, const std::vector<std::int32_t>&);

}  // namespace gabion
