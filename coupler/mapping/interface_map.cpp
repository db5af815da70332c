// SPDX-License-Identifier: BSD-3-Clause
#include "coupler/mapping/interface_map.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/Geometry>
#include <set>

#include "common/base/log.hpp"
#include "common/base/require.hpp"
#include "coupler/checks/surface_check.hpp"
#include "coupler/step/state_vectors.hpp"

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

const std::vector<double>& checked(const InterfaceValues& sent, const std::string& participant,
                                   const InterfaceMesh& mesh) {
  const auto found = sent.find(mesh.name);
  require(found != sent.end(), "participant \"{}\" sent nothing for interface \"{}\"", participant,
          mesh.name);
  require(found->second.size() == mesh.coordinates.size(),
          "participant \"{}\" sent {} values for interface \"{}\", expected {}", participant,
          found->second.size(), mesh.name, mesh.coordinates.size());
  return found->second;
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

/// @throws ConfigError  as Mapping does, and says when the surfaces seem to have unequal units
Mapping make_mapping(const InterfaceMesh& structure, const InterfaceMesh& soil,
                     const MappingSettings& settings) {
  try {
    return {structure, soil, settings};
  } catch (const ConfigError& error) {
    throw ConfigError(error.what() + unit_hint(structure, soil));
  }
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
    const auto size = static_cast<Eigen::Index>(structure.coordinates.size());
    interfaces_.push_back(
        {names, soil, structure, make_mapping(structure, soil, settings), size_, size, {}, {}});
    interfaces_.back().reach = settings.moved * extent(structure);
    size_ += size;
    const Mapping& mapping = interfaces_.back().mapping;
    log_report(names, mapping, settings.method);
  }
}

InterfaceValues InterfaceMap::soil_displacement(const std::string& soil,
                                                const Eigen::VectorXd& x) const {
  InterfaceValues result;
  for (const Interface& interface : interfaces_) {
    if (interface.names.soil == soil) result[interface.names.name] = soil_values(interface, x);
  }
  return result;
}

std::vector<double> InterfaceMap::soil_values(const Interface& interface,
                                              const Eigen::VectorXd& x) const {
  std::vector<double> values(interface.soil_mesh.coordinates.size());
  const auto own = x.segment(interface.offset, interface.size);
  if (interface.x_b.size() == 0) {
    interface.mapping.to_soil({own.data(), static_cast<std::size_t>(own.size())}, values);
    return values;
  }
  const Eigen::VectorXd dx = own - interface.x_b;
  interface.mapping.to_soil({dx.data(), static_cast<std::size_t>(dx.size())}, values);
  for (Eigen::Index i = 0; i < interface.u_b.size(); ++i) values[i] += interface.u_b(i);
  return values;
}

void InterfaceMap::accept(const Eigen::VectorXd& x) {
  if (!settings_.deformed) return;
  for (Interface& interface : interfaces_) {
    if (interface.mapping.is_identity()) continue;
    Eigen::VectorXd moved = x.segment(interface.offset, interface.size);
    if (interface.x_b.size() > 0) moved -= interface.x_b;
    const double farthest = moved.reshaped(dim_, moved.size() / dim_).colwise().norm().maxCoeff();
    if (farthest <= interface.reach) continue;
    const std::vector<double> u = soil_values(interface, x);
    interface.u_b = Eigen::Map<const Eigen::VectorXd>(u.data(), std::ssize(u));
    interface.x_b = x.segment(interface.offset, interface.size);
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
  soil.vertices_per_facet = 0;  // which side is which was checked in the reference configuration
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

void InterfaceMap::add_soil_force(const std::string& soil, const InterfaceValues& sent,
                                  Eigen::VectorXd& force) const {
  for (const Interface& interface : interfaces_) {
    if (interface.names.soil != soil) continue;
    interface.mapping.add_to_structure(
        checked(sent, soil, interface.soil_mesh),
        {force.data() + interface.offset, static_cast<std::size_t>(interface.size)});
  }
}

InterfaceValues InterfaceMap::structure_values(const std::string& structure,
                                               const Eigen::VectorXd& all) const {
  InterfaceValues result;
  for (const Interface& interface : interfaces_) {
    if (interface.names.structure != structure) continue;
    const double* begin = all.data() + interface.offset;
    result[interface.names.name].assign(begin, begin + interface.size);
  }
  return result;
}

void InterfaceMap::put_structure_values(const std::string& structure, const InterfaceValues& sent,
                                        Eigen::VectorXd& all) const {
  for (const Interface& interface : interfaces_) {
    if (interface.names.structure != structure) continue;
    const auto& values = checked(sent, structure, interface.structure_mesh);
    all.segment(interface.offset, interface.size) =
        Eigen::Map<const Eigen::VectorXd>(values.data(), interface.size);
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

Resultant InterfaceMap::soil_resultant(const std::string& soil, const InterfaceValues& displacement,
                                       const InterfaceValues& force) const {
  Resultant sum;
  for (const Interface& interface : interfaces_) {
    if (interface.names.soil != soil) continue;
    add_resultant(interface.soil_mesh, displacement.at(interface.names.name).data(),
                  force.at(interface.names.name).data(), sum);
  }
  return sum;
}

Resultant InterfaceMap::structure_resultant(const Eigen::VectorXd& x,
                                            const Eigen::VectorXd& force) const {
  Resultant sum;
  for (const Interface& interface : interfaces_) {
    add_resultant(interface.structure_mesh, x.data() + interface.offset,
                  force.data() + interface.offset, sum);
  }
  return sum;
}

}  // namespace gabion
