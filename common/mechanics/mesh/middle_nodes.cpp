// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cassert>
#include <map>
#include <utility>

#include "common/mechanics/elements/quadratic_cells.hpp"
#include "common/mechanics/mesh/mesh.hpp"

namespace gabion {

namespace {

/// Middle nodes by the corners that they lie between, ascending; each is made once.
template <int dim>
class MiddleNodes {
 public:
  explicit MiddleNodes(std::vector<Vector<dim>>& nodes) : nodes_(nodes) {}

  /// @param corners  of a cell or facet
  void append(CellType type, std::span<const std::int32_t> corners,
              std::vector<std::int32_t>& elements) {
    elements.insert(elements.end(), corners.begin(), corners.end());
    for (const CornerSet set : middle_nodes(type)) {
      std::vector<std::int32_t> between;
      for (std::size_t a = 0; a < corners.size(); ++a) {
        if (set >> a & 1) between.push_back(corners[a]);
      }
      std::ranges::sort(between);
      elements.push_back(node_between(between));
    }
  }

 private:
  std::int32_t node_between(const std::vector<std::int32_t>& corners) {
    const auto [found, added] =
        known_.try_emplace(corners, static_cast<std::int32_t>(nodes_.size()));
    if (added) {
      Vector<dim> sum = Vector<dim>::Zero();
      for (const std::int32_t i : corners) sum += nodes_[i];
      nodes_.push_back(sum / static_cast<double>(corners.size()));
    }
    return found->second;
  }

  std::vector<Vector<dim>>& nodes_;
  std::map<std::vector<std::int32_t>, std::int32_t> known_;
};

}  // namespace

template <int dim>
Mesh<dim> with_middle_nodes(const Mesh<dim>& mesh, CellType type) {
  assert(corner_type(type) == mesh.cell_type);
  Mesh<dim> result = mesh;
  result.cell_type = type;
  result.cells.clear();
  MiddleNodes<dim> middle(result.nodes);
  for (std::int32_t c = 0; c < mesh.num_cells(); ++c) {
    middle.append(type, mesh.cell(c), result.cells);
  }
  const std::size_t n = num_nodes(facet_type(mesh.cell_type));
  for (auto& [name, facets] : result.facet_groups) {
    const std::vector<std::int32_t> corners = std::exchange(facets, {});
    for (std::size_t f = 0; f < corners.size(); f += n) {
      middle.append(facet_type(type), std::span(corners).subspan(f, n), facets);
    }
  }
  return result;
}

template Mesh<2> with_middle_nodes(const Mesh<2>&, CellType);
template Mesh<3> with_middle_nodes(const Mesh<3>&, CellType);

}  // namespace gabion
