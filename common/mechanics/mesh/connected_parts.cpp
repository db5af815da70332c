// SPDX-License-Identifier: BSD-3-Clause
#include "common/mechanics/mesh/connected_parts.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "common/mechanics/mesh/coincident_nodes.hpp"
#include "common/mechanics/mesh/disjoint_sets.hpp"

namespace gabion {

namespace {

constexpr std::size_t shown_places = 3;

template <int dim>
std::string place_text(const Vector<dim>& x) {
  return fmt::format("({:.6g})", fmt::join(x.data(), x.data() + dim, ", "));
}

/// Find the part of each node, -1: no element has it, and give the parts their cells and boxes.
template <int dim>
std::vector<std::int32_t> find_parts(const Mesh<dim>& mesh, MeshConnection<dim>& connection) {
  DisjointSets sets(mesh.nodes.size());
  for (std::int32_t e = 0; e < mesh.num_elements(); ++e) {
    for (const std::int32_t i : mesh.element(e)) sets.join(mesh.element(e)[0], i);
  }
  std::vector<std::int32_t> part(mesh.nodes.size(), -1);  // part of the least node of each set
  for (std::int32_t e = 0; e < mesh.num_elements(); ++e) {
    std::int32_t& number = part[sets.find(mesh.element(e)[0])];
    if (number < 0) {
      number = static_cast<std::int32_t>(connection.parts.size());
      connection.parts.emplace_back();
    }
    ConnectedPart<dim>& of_element = connection.parts[number];
    ++of_element.num_cells;
    for (const std::int32_t i : mesh.element(e)) of_element.box.extend(mesh.nodes[i]);
  }
  for (std::int32_t i = 0; i < mesh.num_nodes_total(); ++i) part[i] = part[sets.find(i)];
  return part;
}

}  // namespace

template <int dim>
MeshConnection<dim> connection_of(const Mesh<dim>& mesh) {
  MeshConnection<dim> connection;
  const auto part = find_parts(mesh, connection);
  for (const auto* groups : {&mesh.node_groups, &mesh.facet_groups}) {
    for (const auto& [name, nodes] : *groups) {
      for (const std::int32_t i : nodes) {
        if (part[i] >= 0) connection.parts[part[i]].groups.insert(name);
      }
    }
  }
  const auto first = nodes_in_place<dim>(mesh.nodes, coincidence_distance(mesh));
  std::vector<char> is_shared(first.size(), 0), between_parts(first.size(), 0);
  for (std::int32_t i = 0; i < mesh.num_nodes_total(); ++i) {
    const std::int32_t f = first[i];
    if (f == i) continue;
    if (is_shared[f] == 0) {
      ++connection.num_unjoined;
      auto& shown = connection.first_unjoined;
      if (shown.size() < shown_places) shown.push_back(mesh.nodes[f]);
    }
    is_shared[f] = 1;
    if (part[i] != part[f]) between_parts[f] = 1;
  }
  for (std::int32_t i = 0; i < mesh.num_nodes_total(); ++i) {
    if (is_shared[first[i]] != 0) connection.unjoined.push_back(i);
    if (between_parts[first[i]] != 0 && part[i] >= 0) ++connection.parts[part[i]].num_touching;
  }
  return connection;
}

template <int dim>
std::string unjoined_text(const MeshConnection<dim>& connection) {
  std::vector<std::string> places;
  for (const Vector<dim>& x : connection.first_unjoined) places.push_back(place_text<dim>(x));
  return fmt::format("{} {} with several nodes that are not joined, such as {}",
                     connection.num_unjoined, connection.num_unjoined == 1 ? "place" : "places",
                     fmt::join(places, ", "));
}

template <int dim>
std::string text_of(const ConnectedPart<dim>& part) {
  return fmt::format("{} {} from {} to {}", part.num_cells, part.num_cells == 1 ? "cell" : "cells",
                     place_text<dim>(part.box.min()), place_text<dim>(part.box.max()));
}

template MeshConnection<2> connection_of(const Mesh<2>&);
template MeshConnection<3> connection_of(const Mesh<3>&);
template std::string unjoined_text(const MeshConnection<2>&);
template std::string unjoined_text(const MeshConnection<3>&);
template std::string text_of(const ConnectedPart<2>&);
template std::string text_of(const ConnectedPart<3>&);

}  // namespace gabion
