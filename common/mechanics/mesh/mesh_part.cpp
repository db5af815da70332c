// SPDX-License-Identifier: BSD-3-Clause
#include "common/mechanics/mesh/mesh_part.hpp"

#include <algorithm>

namespace gabion {

template <int dim>
MeshParts<dim>::MeshParts(const Mesh<dim>& mesh, std::vector<int> part_of_cell)
    : mesh_(mesh), part_of_cell_(std::move(part_of_cell)), places_(mesh.nodes.size(), -1) {
  const std::size_t n = num_nodes(facet_type(mesh.cell_type));
  for (const auto& [name, facets] : mesh.facet_groups) given_[name].assign(facets.size() / n, 0);
}

template <int dim>
MeshPart<dim> MeshParts<dim>::take(int part) {
  MeshPart<dim> taken;
  Mesh<dim>& mesh = taken.mesh;
  PartNumbers& numbers = taken.numbers;
  mesh.cell_type = mesh_.cell_type;
  mesh.file = mesh_.file;
  numbers.num_nodes = mesh_.num_nodes_total();
  numbers.num_cells = mesh_.num_cells();
  for (std::int32_t c = 0; c < mesh_.num_cells(); ++c) {
    if (part_of_cell_[c] != part) continue;
    numbers.cells.push_back(c);
    for (const std::int32_t i : mesh_.cell(c)) {
      mesh.cells.push_back(i);
      places_[i] = 0;
    }
  }
  for (std::int32_t i = 0; i < mesh_.num_nodes_total(); ++i) {
    if (places_[i] < 0) continue;
    places_[i] = static_cast<std::int32_t>(numbers.nodes.size());
    numbers.nodes.push_back(i);
    mesh.nodes.push_back(mesh_.nodes[i]);
  }
  for (std::int32_t& i : mesh.cells) i = places_[i];
  take_facets(taken);
  take_cell_groups(taken);
  for (const std::int32_t i : numbers.nodes) places_[i] = -1;
  return taken;
}

template <int dim>
void MeshParts<dim>::take_facets(MeshPart<dim>& part) {
  const std::size_t n = num_nodes(facet_type(mesh_.cell_type));
  for (const auto& [name, facets] : mesh_.facet_groups) {
    auto& own = part.mesh.facet_groups[name];
    auto& numbers = part.numbers.facets[name];
    auto& given = given_.at(name);
    for (std::size_t f = 0; f < given.size(); ++f) {
      const std::span nodes = std::span(facets).subspan(f * n, n);
      const bool here = std::ranges::all_of(nodes, [&](std::int32_t i) { return places_[i] >= 0; });
      if (given[f] != 0 || !here) continue;
      given[f] = 1;
      numbers.push_back(static_cast<std::int64_t>(f));
      for (const std::int32_t i : nodes) own.push_back(places_[i]);
    }
  }
}

template <int dim>
void MeshParts<dim>::take_cell_groups(MeshPart<dim>& part) const {
  const std::vector<std::int32_t>& own = part.numbers.cells;
  for (const auto& [name, cells] : mesh_.cell_groups) {
    auto& taken = part.mesh.cell_groups[name];
    for (const std::int32_t c : cells) {
      const auto found = std::ranges::lower_bound(own, c);
      if (found == own.end() || *found != c) continue;
      taken.push_back(static_cast<std::int32_t>(found - own.begin()));
    }
  }
}

template class MeshParts<2>;
template class MeshParts<3>;

}  // namespace gabion
