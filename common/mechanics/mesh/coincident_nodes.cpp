// SPDX-License-Identifier: BSD-3-Clause
#include "common/mechanics/mesh/coincident_nodes.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "common/mechanics/mesh/disjoint_sets.hpp"
#include "common/mechanics/mesh/mesh_box.hpp"

namespace gabion {

namespace {

constexpr double share_of_side = 1e-6, share_of_edge = 1e-2;

// A direction that no row of nodes is likely to be perpendicular to.
template <int dim>
Vector<dim> odd_direction() {
  constexpr double components[] = {0.5377, 0.6231, 0.3319};
  return Eigen::Map<const Vector<dim>>(components).normalized();
}

}  // namespace

template <int dim>
double coincidence_distance(const Mesh<dim>& mesh) {
  double shortest = std::numeric_limits<double>::infinity();  // squared
  for (std::int32_t e = 0; e < mesh.num_elements(); ++e) {
    const auto cell = mesh.element(e);
    for (std::size_t a = 0; a < cell.size(); ++a) {
      for (std::size_t b = 0; b < a; ++b) {
        shortest = std::min(shortest, (mesh.nodes[cell[a]] - mesh.nodes[cell[b]]).squaredNorm());
      }
    }
  }
  return std::min(share_of_side * box_around(mesh).sizes().maxCoeff(),
                  share_of_edge * std::sqrt(shortest));
}

template <int dim>
std::vector<std::int32_t> nodes_in_place(std::span<const Vector<dim>> nodes, double distance) {
  const Vector<dim> direction = odd_direction<dim>();
  std::vector<std::pair<double, std::int32_t>> along;
  along.reserve(nodes.size());
  for (const Vector<dim>& x : nodes) {
    along.emplace_back(x.dot(direction), static_cast<std::int32_t>(along.size()));
  }
  std::sort(along.begin(), along.end());
  DisjointSets sets(nodes.size());
  for (std::size_t k = 0; k < along.size(); ++k) {
    for (std::size_t l = k + 1; l < along.size(); ++l) {
      if (along[l].first - along[k].first > distance) break;
      const std::int32_t i = along[k].second, j = along[l].second;
      if ((nodes[i] - nodes[j]).norm() <= distance) sets.join(i, j);
    }
  }
  std::vector<std::int32_t> first(nodes.size());
  for (std::size_t i = 0; i < first.size(); ++i) {
    first[i] = sets.find(static_cast<std::int32_t>(i));
  }
  return first;
}

template double coincidence_distance(const Mesh<2>&);
template double coincidence_distance(const Mesh<3>&);
template std::vector<std::int32_t> nodes_in_place<2>(std::span<const Vector<2>>, double);
template std::vector<std::int32_t> nodes_in_place<3>(std::span<const Vector<3>>, double);

}  // namespace gabion
