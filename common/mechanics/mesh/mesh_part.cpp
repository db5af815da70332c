// SPDX-License-Identifier: BSD-3-Clause
#include "common/mechanics/mesh/mesh_part.hpp"

#include <algorithm>

namespace gabion {

template <int dim>
MeshParts<dim>::MeshParts(const Mesh<dim>& mesh, std::vector<int> part_of_element)
    : mesh_(mesh), part_of_element_(std::move(part_of_element)), places_(mesh.nodes.size(), -1) {
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
  numbers.num_lines = mesh_.num_lines();
  for (std::int32_t e = 0; e < mesh_.num_elements(); ++e) {
    if (part_of_element_[e] != part) continue;
    const std::int32_t line = e - mesh_.num_cells(), sheet = line - mesh_.num_lines();
    if (line < 0) numbers.cells.push_back(e);
    if (line >= 0 && sheet < 0) numbers.lines.push_back(line);
    if (sheet >= 0) numbers.sheets.push_back(sheet);
    for (const std::int32_t i : mesh_.element(e)) {
      (line < 0 ? mesh.cells : sheet < 0 ? mesh.lines : mesh.sheets).push_back(i);
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
  for (std::int32_t& i : mesh.lines) i = places_[i];
  for (std::int32_t& i : mesh.sheets) i = places_[i];
  take_facets(taken);
  take_groups(taken);
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

namespace {

/// The groups of the whole, with the places of their members in the part.
/// @param own  numbers of the part in the whole, ascending
void take_members(const NumberGroups& groups, const std::vector<std::int32_t>& own,
                  NumberGroups& taken) {
  for (const auto& [name, members] : groups) {
    auto& places = taken[name];
    for (const std::int32_t m : members) {
      const auto found = std::ranges::lower_bound(own, m);
      if (found == own.end() || *found != m) continue;
      places.push_back(static_cast<std::int32_t>(found - own.begin()));
    }
  }
}

}  // namespace

template <int dim>
void MeshParts<dim>::take_groups(MeshPart<dim>& part) const {
  take_members(mesh_.cell_groups, part.numbers.cells, part.mesh.cell_groups);
  take_members(mesh_.line_groups, part.numbers.lines, part.mesh.line_groups);
  take_members(mesh_.sheet_groups, part.numbers.sheets, part.mesh.sheet_groups);
  take_members(mesh_.node_groups, part.numbers.nodes, part.mesh.node_groups);
}

template class MeshParts<2>;
template class MeshParts<3>;

}  // namespace gabion
