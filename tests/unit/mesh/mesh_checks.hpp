// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <string>

#include "common/mechanics/mesh/boundary.hpp"
#include "common/mechanics/mesh/mesh.hpp"
#include "tests/support/expect_error.hpp"

namespace gabion::test {

template <int dim>
double total_volume(const Mesh<dim>& mesh) {
  double sum = 0;
  for (std::int32_t c = 0; c < mesh.num_cells(); ++c) sum += cell_volume(mesh, c);
  return sum;
}

template <int dim>
double smallest_volume(const Mesh<dim>& mesh) {
  double smallest = cell_volume(mesh, 0);
  for (std::int32_t c = 1; c < mesh.num_cells(); ++c) {
    smallest = std::min(smallest, cell_volume(mesh, c));
  }
  return smallest;
}

/// Volume by the divergence theorem, sum of x . n A / dim; exact for flat facets. Wrong as soon as
/// one facet faces inward.
template <int dim>
double enclosed_volume(const Mesh<dim>& mesh, const std::vector<std::int32_t>& facets) {
  const CellType type = facet_type(mesh.cell_type);
  const auto areas = facet_area_vectors<dim>(mesh.nodes, type, facets);
  const std::size_t n = num_nodes(type);
  double sum = 0;
  for (std::size_t f = 0; f < areas.size(); ++f) {
    Vector<dim> centre = Vector<dim>::Zero();
    for (std::size_t a = 0; a < n; ++a) {
      centre += mesh.nodes[facets[f * n + a]] / static_cast<double>(n);
    }
    sum += centre.dot(areas[f]) / dim;
  }
  return sum;
}

template <int dim>
Vector<dim> resultant_area(const Mesh<dim>& mesh, const std::vector<std::int32_t>& facets) {
  Vector<dim> sum = Vector<dim>::Zero();
  for (const auto& a : facet_area_vectors<dim>(mesh.nodes, facet_type(mesh.cell_type), facets)) {
    sum += a;
  }
  return sum;
}

/// All named facets in one list.
template <int dim>
std::vector<std::int32_t> all_groups(const Mesh<dim>& mesh) {
  std::vector<std::int32_t> all;
  for (const auto& [group, facets] : mesh.facet_groups) {
    all.insert(all.end(), facets.begin(), facets.end());
  }
  return all;
}

}  // namespace gabion::test
