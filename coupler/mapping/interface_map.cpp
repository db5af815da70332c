// SPDX-License-Identifier: BSD-3-Clause
#include "coupler/mapping/interface_map.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <set>

#include "common/base/log.hpp"
#include "common/base/require.hpp"
#include "coupler/mapping/loose_vertices.hpp"
#include "coupler/mapping/surface_extent.hpp"
#include "coupler/state_vectors.hpp"

namespace gabion {

namespace {

using Meshes = std::map<std::string, std::vector<InterfaceMesh>>;

const InterfaceMesh& mesh_of(const Meshes& meshes, const std::string& participant,
                             const std::string& interface) {
  std::vector<std::string> found;
  for (const InterfaceMesh& mesh : meshes.at(participant)) {
    if (mesh.name == interface) return mesh;
    found.push_back(mesh.name);
  }
  throw ConfigError(
      fmt::format("interface \"{}\": participant \"{}\" does not have it; it has: {}", interface,
                  participant, found.empty() ? "none" : fmt::format("{}", fmt::join(found, ", "))));
}

/// The facets of a mesh, each by its vertices in ascending order.
std::set<std::vector<std::int64_t>> facets_of(const InterfaceMesh& mesh) {
  std::set<std::vector<std::int64_t>> all;
  const auto width = static_cast<std::size_t>(mesh.vertices_per_facet);
  for (std::size_t first = 0; width > 0 && first < mesh.facets.size(); first += width) {
    std::vector<std::int64_t> facet(mesh.facets.begin() + first,
                                    mesh.facets.begin() + first + width);
    std::ranges::sort(facet);
    all.insert(std::move(facet));
  }
  return all;
}

void check_all_coupled(const std::vector<InterfaceSettings>& interfaces, const Meshes& meshes) {
  std::set<std::pair<std::string, std::string>> coupled;
  for (const auto& entry : interfaces) {
    coupled.emplace(entry.soil, entry.name);
    coupled.emplace(entry.structure, entry.name);
  }
  for (const auto& [participant, surfaces] : meshes) {
    for (const InterfaceMesh& mesh : surfaces) {
      require<ConfigError>(
          coupled.contains({participant, mesh.name}),
          "participant \"{}\" offers the interface \"{}\", which \"interfaces\" in "
          "coupler.json does not couple",
          participant, mesh.name);
    }
  }
}

/// The part of a vector over all interfaces that belongs to the interface with this mesh.
std::span<const double> part(const Eigen::VectorXd& all, Eigen::Index begin,
                             const InterfaceMesh& mesh) {
  return {all.data() + begin, mesh.coordinates.size()};
}
std::span<double> part(Eigen::VectorXd& all, Eigen::Index begin, const InterfaceMesh& mesh) {
  return {all.data() + begin, mesh.coordinates.size()};
}

template <int dim>
void add_resultant(const double* X, const double* u, const double* force, std::int64_t num_vertices,
                   Resultant& sum) {
  Eigen::Vector3d x = Eigen::Vector3d::Zero();
  Eigen::Vector3d f = Eigen::Vector3d::Zero();
  for (std::int64_t k = 0; k < num_vertices * dim; k += dim) {
    for (int i = 0; i < dim; ++i) {
      x(i) = X[k + i] + u[k + i];
      f(i) = force[k + i];
    }
    sum.force += f;
    sum.moment += x.cross(f);
  }
}

void add_resultant(const InterfaceMesh& mesh, const double* u, const double* force,
                   Resultant& sum) {
  const auto add = mesh.dim == 2 ? add_resultant<2> : add_resultant<3>;
  add(mesh.coordinates.data(), u, force, mesh.num_vertices(), sum);
}

/// @throws ConfigError  as Mapping does, and says where the interface is, when the surfaces seem
///                      to have unequal units, and when one side alone has cells behind it
Mapping make_mapping(const InterfaceSettings& names, const InterfaceMesh& structure,
                     const InterfaceMesh& soil, const MappingSettings& settings) {
  try {
    return {structure, soil, settings};
  } catch (const ConfigError& error) {
    throw ConfigError((names.where.empty() ? "" : names.where + ": ") + error.what() +
                      unit_hint(structure, soil) + behind_hint(structure, soil));
  }
}

void check_moment_about(const InterfaceSettings& names, int dim) {
  const std::size_t size = names.moment_about.size();
  require<ConfigError>(size == 0 || size == static_cast<std::size_t>(dim),
                       "interface \"{}\": found \"moment_about\" with {} numbers, allowed: {}",
                       names.name, size, dim);
}

void log_report(const InterfaceSettings& names, const Mapping& mapping, const std::string& method) {
  const MappingReport& report = mapping.report();
  log::info("interface {}: {} vertices of {} on {} of {} ({}), farthest {:.3g} m", names.name,
            report.soil_vertices, names.soil, report.structure_vertices, names.structure,
            mapping.is_identity() ? "same vertices: mapping skipped" : method, report.farthest);
  if (mapping.is_identity()) return;
  log::info("interface {}: positions are mapped to {:.3g} m, largest weight {:.3g}", names.name,
            report.largest_shift, report.largest_weight);
  if (report.unused_vertices > 0) {
    log::info("interface {}: no force comes to {} vertices of {}, no vertex of {} is near them",
              names.name, report.unused_vertices, names.structure, names.soil);
  }
}

}  // namespace

InterfaceMap::InterfaceMap(const std::vector<InterfaceSettings>& interfaces, const Meshes& meshes,
                           const MappingSettings& settings)
    : settings_(settings) {
  check_all_coupled(interfaces, meshes);
  for (const InterfaceSettings& names : interfaces) {
    const InterfaceMesh& soil = mesh_of(meshes, names.soil, names.name);
    const InterfaceMesh& structure = mesh_of(meshes, names.structure, names.name);
    if (interfaces_.empty()) dim_ = structure.dim;
    require<ConfigError>(structure.dim == dim_,
                         "interface \"{}\" has dimension {}, interface \"{}\" has {}; "
                         "allowed: equal",
                         names.name, structure.dim, interfaces.front().name, dim_);
    check_moment_about(names, dim_);
    interfaces_.push_back({.names = names,
                           .soil_mesh = soil,
                           .structure_mesh = structure,
                           .mapping = make_mapping(names, structure, soil, settings),
                           .begin = size_,
                           .reach = settings.moved * extent(structure)});
    size_ += std::ssize(structure.coordinates);
    log_report(names, interfaces_.back().mapping, settings.method);
  }
  place_soils();
}

/// Place the interfaces soil by soil, those of a soil by name.
void InterfaceMap::place_soils() {
  std::map<std::pair<std::string, std::string>, Interface*> ordered;
  for (Interface& interface : interfaces_) {
    ordered[{interface.names.soil, interface.names.name}] = &interface;
  }
  for (const auto& entry : ordered) {
    entry.second->soil_begin = soil_size_;
    soil_size_ += std::ssize(entry.second->soil_mesh.coordinates);
  }
}

InterfaceLayout InterfaceMap::layout(const std::string& participant) const {
  std::vector<InterfacePlace> places;
  for (const Interface& interface : interfaces_) {
    const bool is_soil = interface.names.soil == participant;
    if (!is_soil && interface.names.structure != participant) continue;
    const InterfaceMesh& mesh = is_soil ? interface.soil_mesh : interface.structure_mesh;
    places.push_back({.name = interface.names.name,
                      .begin = is_soil ? interface.soil_begin : interface.begin,
                      .size = std::ssize(mesh.coordinates)});
  }
  return {participant, places};
}

bool InterfaceMap::has_same_vertices(const std::string& interface) const {
  return std::ranges::any_of(interfaces_, [&](const Interface& own) {
    return own.names.name == interface && own.mapping.is_identity();
  });
}

void InterfaceMap::require_same_facets(const std::string& interface) const {
  const auto& own = *std::ranges::find_if(
      interfaces_, [&](const Interface& each) { return each.names.name == interface; });
  if (own.structure_mesh.vertices_per_facet != own.soil_mesh.vertices_per_facet) {
    return;  // refused by the soil
  }
  const auto theirs = facets_of(own.structure_mesh), of_soil = facets_of(own.soil_mesh);
  require<ConfigError>(
      theirs == of_soil,
      "interface \"{}\": \"{}\" begins with {} facets, \"{}\" with {}, of which {} are the same; "
      "allowed where facets may leave: the same ones: equal \"groups\" in \"surface\" of mpm.json "
      "and in the interface of fem.json",
      interface, own.names.structure, theirs.size(), own.names.soil, of_soil.size(),
      std::ranges::count_if(of_soil, [&](const auto& facet) { return theirs.contains(facet); }));
}

Eigen::VectorXd InterfaceMap::soil_displacement(const Eigen::VectorXd& x) const {
  Eigen::VectorXd u(soil_size_);
  for (const Interface& interface : interfaces_) {
    soil_values(interface, x, part(u, interface.soil_begin, interface.soil_mesh));
  }
  return u;
}

void InterfaceMap::soil_values(const Interface& interface, const Eigen::VectorXd& x,
                               std::span<double> u) const {
  const auto own = part(x, interface.begin, interface.structure_mesh);
  if (interface.x_b.size() == 0) return interface.mapping.to_soil(own, u);
  std::vector<double> dx(own.begin(), own.end());
  for (Eigen::Index i = 0; i < interface.x_b.size(); ++i) dx[i] -= interface.x_b(i);
  interface.mapping.to_soil(dx, u);
  for (Eigen::Index i = 0; i < interface.u_b.size(); ++i) u[i] += interface.u_b(i);
}

Eigen::VectorXd InterfaceMap::structure_force(const Eigen::VectorXd& f_soil) const {
  Eigen::VectorXd f = Eigen::VectorXd::Zero(size_);
  for (const Interface& interface : interfaces_) {
    interface.mapping.add_to_structure(part(f_soil, interface.soil_begin, interface.soil_mesh),
                                       part(f, interface.begin, interface.structure_mesh));
  }
  return f;
}

void InterfaceMap::accept(const Eigen::VectorXd& x) {
  if (!settings_.deformed) return;
  for (Interface& interface : interfaces_) {
    if (interface.mapping.is_identity()) continue;
    const Eigen::VectorXd x_own =
        x.segment(interface.begin, std::ssize(interface.structure_mesh.coordinates));
    Eigen::VectorXd moved = x_own;
    if (interface.x_b.size() > 0) moved -= interface.x_b;
    const double farthest = moved.reshaped(dim_, moved.size() / dim_).colwise().norm().maxCoeff();
    if (farthest <= interface.reach) continue;
    Eigen::VectorXd u(std::ssize(interface.soil_mesh.coordinates));
    soil_values(interface, x, part(u, 0, interface.soil_mesh));
    interface.u_b = u;
    interface.x_b = x_own;
    set_up(interface);
    ++interface.num_set_ups;
  }
}

void InterfaceMap::set_up(Interface& interface) const {
  InterfaceMesh structure = interface.structure_mesh;
  InterfaceMesh soil = interface.soil_mesh;
  for (Eigen::Index i = 0; i < interface.x_b.size(); ++i) {
    structure.coordinates[i] += interface.x_b(i);
  }
  for (Eigen::Index i = 0; i < interface.u_b.size(); ++i) soil.coordinates[i] += interface.u_b(i);
  soil.vertices_per_facet = 0;  // orientations were checked in the reference configuration
  soil.facets.clear();
  interface.mapping = Mapping(structure, soil, settings_);
}

void InterfaceMap::visit_state(StateVisitor& visitor) {
  if (!settings_.deformed) return;
  for (Interface& interface : interfaces_) {
    const Eigen::VectorXd before = interface.x_b;
    visit_vector(visitor, "map.x_b." + interface.names.name, interface.x_b);
    visit_vector(visitor, "map.u_b." + interface.names.name, interface.u_b);
    const Eigen::VectorXd& now = interface.x_b;
    if (now.size() != before.size() || now != before) set_up(interface);
  }
}

Json InterfaceMap::report() const {
  Json all = Json::object();
  for (const Interface& interface : interfaces_) {
    const MappingReport& report = interface.mapping.report();
    all[interface.names.name] = {{"identity", interface.mapping.is_identity()},
                                 {"soil_vertices", report.soil_vertices},
                                 {"structure_vertices", report.structure_vertices},
                                 {"unused_vertices", report.unused_vertices},
                                 {"farthest", report.farthest},
                                 {"largest_shift", report.largest_shift},
                                 {"largest_weight", report.largest_weight},
                                 {"set_ups", interface.num_set_ups}};
  }
  return all;
}

Resultant InterfaceMap::soil_resultant(const Eigen::VectorXd& u,
                                       const Eigen::VectorXd& f_soil) const {
  std::map<std::string, Resultant> of_soil;
  for (const Interface& interface : interfaces_) {
    add_resultant(interface.soil_mesh, u.data() + interface.soil_begin,
                  f_soil.data() + interface.soil_begin, of_soil[interface.names.soil]);
  }
  Resultant sum;
  for (const auto& entry : of_soil) {
    sum.force += entry.second.force;
    sum.moment += entry.second.moment;
  }
  return sum;
}

Resultant InterfaceMap::structure_resultant(const Eigen::VectorXd& x,
                                            const Eigen::VectorXd& f) const {
  Resultant sum;
  for (const Interface& interface : interfaces_) {
    add_resultant(interface.structure_mesh, x.data() + interface.begin, f.data() + interface.begin,
                  sum);
  }
  return sum;
}

std::vector<Resultant> InterfaceMap::structure_resultants(const Eigen::VectorXd& x,
                                                          const Eigen::VectorXd& f) const {
  std::vector<Resultant> all;
  for (const Interface& interface : interfaces_) {
    Resultant& own = all.emplace_back();
    add_resultant(interface.structure_mesh, x.data() + interface.begin, f.data() + interface.begin,
                  own);
    Eigen::Vector3d about = Eigen::Vector3d::Zero();
    const auto& place = interface.names.moment_about;
    for (std::size_t i = 0; i < place.size(); ++i) about(static_cast<Eigen::Index>(i)) = place[i];
    own.moment -= about.cross(own.force);
  }
  return all;
}

}  // namespace gabion
