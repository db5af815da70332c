// SPDX-License-Identifier: BSD-3-Clause
#include "fem_solver/supports/held_parts.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "common/base/log.hpp"
#include "common/mechanics/mesh/coincident_nodes.hpp"

namespace gabion::fem {

namespace {

/// Components of the motion of a part that supports, prescribed displacements or springs hold.
template <int dim>
std::array<bool, dim> held_components(const FemSettings<dim>& settings,
                                      const ConnectedPart<dim>& part) {
  std::array<bool, dim> held{};
  for (const auto& support : settings.supports) {
    if (!part.groups.contains(support.group)) continue;
    for (const int c : support.components) held[c] = true;
  }
  for (const auto& prescribed : settings.prescribed) {
    if (part.groups.contains(prescribed.group)) held[prescribed.component] = true;
  }
  for (const auto& spring : settings.springs) {
    const bool here = spring.point ? part.box.squaredExteriorDistance(*spring.point) == 0
                                   : part.groups.contains(spring.group);
    for (int c = 0; c < dim && here; ++c) held[c] = held[c] || spring.stiffness[c] > 0;
  }
  return held;
}

/// Join the holds of parts with a rigid link between them: what holds one holds both.
template <int dim>
void join_linked(const FemSettings<dim>& settings, std::span<const ConnectedPart<dim>> parts,
                 std::vector<std::array<bool, dim>>& held) {
  for (std::size_t round = 0; round < parts.size(); ++round) {
    for (const RigidLinkSettings& link : settings.rigid_links) {
      std::array<bool, dim> any{};
      const auto is_linked = [&](std::size_t k) {
        return parts[k].groups.contains(link.beam) || parts[k].groups.contains(link.group);
      };
      for (std::size_t k = 0; k < parts.size(); ++k) {
        for (int c = 0; c < dim && is_linked(k); ++c) any[c] = any[c] || held[k][c];
      }
      for (std::size_t k = 0; k < parts.size(); ++k) {
        if (is_linked(k)) held[k] = any;
      }
    }
  }
}

/// Without the places whose nodes all are of one rigid link, which passes forces there.
template <int dim>
MeshConnection<dim> without_linked_places(const FemSettings<dim>& settings,
                                          MeshConnection<dim> connection) {
  const Mesh<dim>& mesh = settings.mesh;
  const double near = coincidence_distance(mesh);
  for (const RigidLinkSettings& link : settings.rigid_links) {
    std::set<std::int32_t> linked;
    for (const std::string& group : {link.beam, link.group}) {
      const auto nodes = settings.ranks.group_nodes(mesh, group, link.where);
      linked.insert(nodes.begin(), nodes.end());
    }
    for (const std::int32_t b : settings.ranks.group_nodes(mesh, link.beam, link.where)) {
      const auto is_here = [&](const Vector<dim>& x) { return (x - mesh.nodes[b]).norm() <= near; };
      std::int64_t here = 0, linked_here = 0;
      for (const std::int32_t i : connection.unjoined) {
        if (!is_here(mesh.nodes[i])) continue;
        ++here;
        linked_here += linked.count(i);
      }
      if (here == 0 || linked_here < here) continue;
      --connection.num_unjoined;
      std::erase_if(connection.first_unjoined, is_here);
    }
  }
  return connection;
}

template <int dim>
std::string touching_text(const MeshConnection<dim>& connection, const ConnectedPart<dim>& part) {
  if (part.num_touching == 0) return "";
  return fmt::format("; {} of its nodes lie in the place of a node of another part: {} ({})",
                     part.num_touching, how_to_join, unjoined_text(connection));
}

}  // namespace

template <int dim>
void check_held_parts(const ConfigReader& in, const FemSettings<dim>& settings,
                      const MeshConnection<dim>& found) {
  const MeshConnection<dim> connection =
      settings.rigid_links.empty() ? found : without_linked_places(settings, found);
  const auto& parts = connection.parts;
  std::vector<std::array<bool, dim>> held;
  for (const auto& part : parts) held.push_back(held_components(settings, part));
  if (!settings.rigid_links.empty()) join_linked<dim>(settings, parts, held);
  const auto is_held = [](const std::array<bool, dim>& components) {
    return std::ranges::any_of(components, [](bool component) { return component; });
  };
  const bool any_held = std::ranges::any_of(held, is_held);
  const bool needs_all = !settings.dynamic || settings.initial_equilibrium;
  std::int64_t num_free = 0;
  for (std::size_t k = 0; parts.size() > 1 && k < parts.size(); ++k) {
    const auto missing = std::ranges::find(held[k], false) - held[k].begin();
    const bool refused =
        needs_all ? missing < dim : any_held && !is_held(held[k]) && parts[k].num_touching > 0;
    const std::string what = fmt::format(
        "found {} parts that share no nodes, and part {}, {}, is held by nothing{}{}", parts.size(),
        k + 1, text_of(parts[k]),
        needs_all && missing < dim ? fmt::format(" in {}", component_names[missing]) : "",
        touching_text(connection, parts[k]));
    if (refused)
      in.fail("mesh", what + "; allowed: supports for each part, or parts that are joined");
    if (!any_held || is_held(held[k])) continue;
    if (++num_free == 1) log::warn("{}: {}: it moves freely", in.where("mesh"), what);
  }
  if (num_free > 1) {
    log::warn("{}: {} of {} parts are held by nothing", in.where("mesh"), num_free, parts.size());
  }
  if (connection.num_unjoined > 0) {
    log::warn("{}: found {}: no force passes there; where the structure is one piece, {}",
              in.where("mesh"), unjoined_text(connection), how_to_join);
  }
}

template void check_held_parts(const ConfigReader&, const FemSettings<2>&,
                               const MeshConnection<2>&);
template void check_held_parts(const ConfigReader&, const FemSettings<3>&,
                               const MeshConnection<3>&);

}  // namespace gabion::fem
