// SPDX-License-Identifier: BSD-3-Clause
#include "fem_solver/fem_config.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <iterator>
#include <limits>
#include <set>
#include <utility>

#include "common/base/log.hpp"
#include "common/mechanics/materials/own_weight.hpp"
#include "common/mechanics/mesh/seen_facets.hpp"
#include "common/mechanics/ranks/text.hpp"
#include "common/settings/plausible.hpp"
#include "fem_solver/flat_cells.hpp"
#include "fem_solver/mesh_settings.hpp"
#include "fem_solver/motion_settings.hpp"
#include "fem_solver/nodal_settings.hpp"
#include "fem_solver/supports/embedded_lines.hpp"
#include "fem_solver/supports/held_parts.hpp"
#include "fem_solver/supports/link_nodes.hpp"
#include "fem_solver/supports/rotation_nodes.hpp"

namespace gabion::fem {

namespace {

template <int dim>
std::vector<std::string> allowed_components() {
  return {component_names, component_names + dim};
}

/// Numbers of the components in a list, each of the allowed ones at most once.
std::vector<int> numbers_of(const ConfigReader& in, const std::string& key,
                            const std::vector<std::string>& words,
                            const std::vector<std::string>& allowed) {
  std::vector<int> result;
  for (std::size_t i = 0; i < words.size(); ++i) {
    const auto found = std::find(allowed.begin(), allowed.end(), words[i]);
    if (found == allowed.end()) {
      in.fail(fmt::format("{}/{}", key, i),
              fmt::format("found \"{}\", allowed: {}", words[i], fmt::join(allowed, ", ")));
    }
    if (std::find(words.begin(), words.begin() + i, words[i]) != words.begin() + i) {
      in.fail(fmt::format("{}/{}", key, i),
              fmt::format("found \"{}\" a second time, allowed: each component once", words[i]));
    }
    result.push_back(static_cast<int>(std::ranges::find(component_names, words[i]) -
                                      std::begin(component_names)));
  }
  return result;
}

template <int dim>
std::vector<int> read_components(ConfigReader& in) {
  const auto allowed = allowed_components<dim>();
  const auto words = in.texts_or("components", allowed);
  if (words.empty()) in.fail("components", "found [], allowed: at least one component");
  return numbers_of(in, "components", words, allowed);
}

/// Axes about which beams do not turn; in the plane it is z.
template <int dim>
std::vector<int> read_rotations(ConfigReader& in) {
  const std::vector<std::string> plane = {"z"};
  const auto allowed = dim == 2 ? plane : allowed_components<3>();
  return numbers_of(in, "rotations",
                    in.has("rotations") ? in.texts("rotations") : std::vector<std::string>(),
                    allowed);
}

template <int dim>
SupportSettings read_support(ConfigReader in) {
  SupportSettings s;
  s.group = in.text("group");
  s.where = in.where("group");
  s.components = read_components<dim>(in);
  s.rotations = read_rotations<dim>(in);
  s.report_reaction = in.boolean("report_reaction");
  s.report_moment = in.boolean("report_moment");
  in.finish();
  return s;
}

template <int dim>
PrescribedSettings read_prescribed(ConfigReader in) {
  PrescribedSettings p;
  p.group = in.text("group");
  p.where = in.where("group");
  const auto allowed = allowed_components<dim>();
  const std::string component = in.choice("component", allowed);
  p.component =
      static_cast<int>(std::find(allowed.begin(), allowed.end(), component) - allowed.begin());
  if (in.has("rate") == in.has("table")) {
    in.fail("rate", "allowed: either \"rate\" [m/s] or \"table\" [[time, displacement], ...]");
  }
  p.displacement = in.has("rate") ? TimeFunction::ramp(in.number("rate")) : read_time_table(in);
  in.finish();
  return p;
}

template <int dim>
TractionSettings<dim> read_traction(ConfigReader in) {
  TractionSettings<dim> t;
  t.group = in.text("group");
  t.where = in.where("group");
  t.traction = read_vector<dim>(in, "traction");
  t.factor = read_factor(in);
  in.finish();
  return t;
}

template <int dim>
ProbeSettings<dim> read_probe(ConfigReader in) {
  ProbeSettings<dim> p;
  p.name = in.name("name");
  p.point = read_vector<dim>(in, "point");
  p.where = in.where("point");
  in.finish();
  return p;
}

// Refuse a component of a group that an earlier support fixes.
void require_distinct_supports(const ConfigReader& in,
                               const std::vector<SupportSettings>& supports) {
  std::set<std::pair<std::string, int>> fixed;
  for (std::size_t i = 0; i < supports.size(); ++i) {
    for (const int component : supports[i].components) {
      if (fixed.emplace(supports[i].group, component).second) continue;
      in.fail(fmt::format("supports/{}/group", i),
              fmt::format("found \"{}\" with component {} a second time, allowed: once",
                          supports[i].group, component_names[component]));
    }
  }
}

// Refuse a facet that an interface takes twice, or that an earlier one has.
template <int dim>
void require_distinct_facets(const ConfigReader& in, const FemSettings<dim>& s) {
  const std::size_t n = num_nodes(facet_type(s.mesh.cell_type));
  SeenFacets<dim> seen;
  for (std::size_t i = 0; i < s.interfaces.size(); ++i) {
    const auto& groups = s.interfaces[i].groups;
    for (std::size_t g = 0; g < groups.size(); ++g) {
      const std::span<const std::int32_t> facets = s.mesh.facets(groups[g], s.interfaces[i].where);
      for (std::size_t f = 0; f < facets.size(); f += n) {
        if (seen.add(s.mesh.nodes, facets.subspan(f, n))) continue;
        in.fail(fmt::format("interfaces/{}/groups/{}", i, g),
                fmt::format("found facets of \"{}\" a second time, allowed: each facet in one "
                            "interface and once",
                            groups[g]));
      }
    }
  }
}

// Refuse a direction that nothing holds: without inertia it makes the matrix singular.
template <int dim>
void require_support(const ConfigReader& in, const FemSettings<dim>& s) {
  for (int c = 0; c < dim; ++c) {
    const bool held =
        std::any_of(s.supports.begin(), s.supports.end(),
                    [c](const auto& item) {
                      return std::count(item.components.begin(), item.components.end(), c) > 0;
                    }) ||
        std::any_of(s.prescribed.begin(), s.prescribed.end(),
                    [c](const auto& item) { return item.component == c; }) ||
        std::any_of(s.springs.begin(), s.springs.end(),
                    [c](const auto& item) { return item.stiffness[c] > 0; });
    if (held) continue;
    in.fail("supports",
            fmt::format("found none that holds the structure in {}, allowed with {}: "
                        "supports, prescribed displacements or springs in every direction",
                        component_names[c],
                        s.dynamic ? "\"initial_equilibrium\"" : "\"analysis\" \"static\""));
  }
}

/// Names of interfaces on facets and around beams, and the groups of these.
template <int dim>
void require_distinct_interfaces(const ConfigReader& in, const FemSettings<dim>& s) {
  std::set<std::string> names, groups;
  for (const auto& item : s.interfaces) names.insert(item.name);
  require_distinct_names(in, "interfaces", s.interfaces);
  for (const auto& item : s.beam_surfaces) {
    if (!names.insert(item.name).second) {
      in.fail(
          "interfaces",
          fmt::format("found the name \"{}\" a second time, allowed: distinct names", item.name));
    }
    for (const std::string& group : item.groups) {
      if (groups.insert(group).second) continue;
      throw ConfigError(item.where + ": found \"" + group +
                        "\", which another interface has, allowed: each group once");
    }
  }
}

template <int dim>
void read_conditions(ConfigReader& in, FemSettings<dim>& s) {
  for (auto& item : in.objects("supports")) {
    s.supports.push_back(read_support<dim>(item));
  }
  for (auto& item : in.objects("prescribed")) {
    s.prescribed.push_back(read_prescribed<dim>(item));
  }
  for (auto& item : in.objects("loads")) s.loads.push_back(read_load<dim>(item));
  for (auto& item : in.objects("point_masses")) {
    s.point_masses.push_back(read_point_mass<dim>(item));
  }
  for (auto& item : in.objects("springs")) s.springs.push_back(read_spring<dim>(item));
  for (auto& item : in.objects("dashpots")) s.dashpots.push_back(read_dashpot<dim>(item));
  for (auto& item : in.objects("tractions")) {
    s.tractions.push_back(read_traction<dim>(item));
  }
  for (auto& item : in.objects("rigid_links")) s.rigid_links.push_back(read_rigid_link(item));
  for (auto& item : in.objects("interfaces")) {
    if (item.has("beams")) {
      s.beam_surfaces.push_back(read_beam_surface(item));
    } else {
      s.interfaces.push_back(read_interface(item, "groups"));
    }
  }
  s.probes = read_probes<dim>(in);
  s.sections = read_sections<dim>(in);
  require_distinct_interfaces(in, s);
  require_distinct_supports(in, s.supports);
  together<ConfigError>(s.ranks.comm(), [&] { require_distinct_facets(in, s); });
  if (s.initial_equilibrium || !s.dynamic) require_support(in, s);
  if (s.supports.empty() && s.prescribed.empty() && s.springs.empty()) {
    log::warn("{}: found no supports and nothing prescribed: the structure moves freely",
              in.where("supports"));
  }
}

/// Warn of facet groups that the file of the mesh names, and no condition, load or interface does.
template <int dim>
void warn_of_unused_groups(const ConfigReader& in, const FemSettings<dim>& s) {
  if (s.mesh.file.empty()) return;  // a box names its sides in any case
  std::set<std::string> used;
  for (const auto& item : s.supports) used.insert(item.group);
  for (const auto& item : s.prescribed) used.insert(item.group);
  for (const auto& item : s.loads) used.insert(item.group);
  for (const auto& item : s.point_masses) used.insert(item.group);
  for (const auto& item : s.springs) used.insert(item.group);
  for (const auto& item : s.dashpots) used.insert(item.group);
  for (const auto& item : s.tractions) used.insert(item.group);
  for (const auto& item : s.interfaces) used.insert(item.groups.begin(), item.groups.end());
  for (const auto& item : s.line_materials) used.insert(item.group);
  for (const auto& item : s.rigid_links) used.insert(item.group);
  for (const auto& item : s.membranes) used.insert(item.group);
  for (const auto& [name, facets] : s.mesh.facet_groups) {
    if (used.contains(name)) continue;
    log::warn("{}: nothing uses the facet group \"{}\" of {}", in.where("mesh"), name, s.mesh.file);
  }
}

/// Log what the structure does under its own weight.
template <int dim>
void check_own_weight(const ConfigReader& in, const FemSettings<dim>& s) {
  const double g = s.gravity.norm();
  const Vector<dim> down = g > 0 ? Vector<dim>(s.gravity / g) : Vector<dim>::Zero();
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (const Vector<dim>& x : s.mesh.nodes) {
    low = std::min(low, x.dot(down));
    high = std::max(high, x.dot(down));
  }
  const SharedNodes& shared = s.ranks.shared();
  const double height = shared.largest(high) + shared.largest(-low);
  for (std::size_t m = 0; m < s.materials.size(); ++m) {
    const CellMaterial<dim>& material = s.materials[m];
    const double modulus =
        std::visit([](const auto& law) { return law.p_wave_modulus(); }, material.law);
    const std::string key = material.group.empty() ? "material" : fmt::format("materials/{}", m);
    log_own_weight(
        in.where(key),
        {.density = material.density, .p_wave_modulus = modulus, .gravity = g, .height = height});
  }
}

}  // namespace

int read_dimension(ConfigReader& in) {
  return in.integer("dimension");
}

WetSurfaceSettings read_interface(ConfigReader in, const std::string& surface) {
  WetSurfaceSettings s;
  s.name = in.name("name");
  const std::string other = surface == "groups" ? "facets" : "groups";
  if (in.has(other) || !in.has(surface)) {
    in.fail(surface,
            fmt::format("missing; \"groups\" names facets of a mesh, \"facets\" the file of "
                        "those beside \"matrices\""));
  }
  s.where = in.where(surface);
  if (surface == "groups") {
    s.groups = in.texts("groups");
  } else {
    s.groups = {in.text("facets")};
  }
  if (s.groups.empty()) in.fail("groups", "found [], allowed: at least one facet group");
  s.behind_where = in.where("behind");
  if (in.has("behind")) {
    if (surface != "groups") in.fail("behind", "allowed with \"groups\" of a mesh alone");
    s.behind = in.texts("behind");
  }
  in.finish();
  return s;
}

template <int dim>
std::vector<ProbeSettings<dim>> read_probes(ConfigReader& in) {
  std::vector<ProbeSettings<dim>> probes;
  for (auto& item : in.objects("probes")) probes.push_back(read_probe<dim>(item));
  require_distinct_names(in, "probes", probes);
  return probes;
}

template <int dim>
FemSettings<dim> read_fem_settings(const Scene& scene, ConfigReader& in, MPI_Comm comm) {
  FemSettings<dim> s;
  if (in.has("matrices")) in.fail("matrices", "allowed: either \"matrices\" or \"mesh\"");
  read_materials_of_all(in, comm, s);
  auto ranked = read_mesh_with_lines<dim>(scene, in, s, comm);
  s.mesh = std::move(ranked.mesh);
  s.ranks = std::move(ranked.ranks);
  add_rotation_nodes(in, s);
  s.gravity = read_vector<dim>(in, "gravity");
  read_motion_with_lines(in, s);
  if (s.dynamic) s.lumped_mass = in.choice("mass") == "lumped";
  if (!s.dynamic && in.has("mass")) {
    in.fail("mass", "has no meaning when \"analysis\" is \"static\"");
  }
  read_conditions(in, s);
  check_membranes_behind(s);
  embed_lines(s, ranked.connection);
  check_damping(s);
  check_rotations(s);
  check_rigid_links(s);
  together<ConfigError>(comm, [&] { check_held_parts(in, s, ranked.connection); });
  warn_of_unused_groups(in, s);
  if (s.coupled()) require_balance_at_end_of_step(in, s.time_integration);
  s.newton = read_newton_settings(in.object("newton"));
  s.linear_solver = read_linear_solver_settings(in.object("linear_solver"));
  if (in.has("$schema")) in.text("$schema");
  warn_of_implausible_settings(in, Described::structure);
  check_own_weight(in, s);
  warn_of_flat_cells(s, comm);
  return s;
}

template std::vector<ProbeSettings<2>> read_probes<2>(ConfigReader&);
template std::vector<ProbeSettings<3>> read_probes<3>(ConfigReader&);
template FemSettings<2> read_fem_settings<2>(const Scene&, ConfigReader&, MPI_Comm);
template FemSettings<3> read_fem_settings<3>(const Scene&, ConfigReader&, MPI_Comm);

}  // namespace gabion::fem
