// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/mpm_config.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "common/base/log.hpp"
#include "common/mechanics/mesh/mesh_box.hpp"
#include "common/settings/plausible.hpp"
#include "mpm_solver/boulders/boulder_config.hpp"
#include "mpm_solver/checks/cell_filling.hpp"
#include "mpm_solver/checks/grid_mesh.hpp"
#include "mpm_solver/checks/group_needs.hpp"
#include "mpm_solver/checks/phase_needs.hpp"
#include "mpm_solver/checks/pools.hpp"
#include "mpm_solver/checks/seepage.hpp"
#include "mpm_solver/checks/snap_back.hpp"
#include "mpm_solver/config_checks.hpp"
#include "mpm_solver/contact/contact_config.hpp"
#include "mpm_solver/contact/group_config.hpp"
#include "mpm_solver/gauges/gauge_config.hpp"
#include "mpm_solver/grid/basis.hpp"
#include "mpm_solver/points/rain.hpp"
#include "mpm_solver/stress/softening_average_config.hpp"

namespace gabion::mpm {

namespace {

template <int dim>
Vector<dim> to_vector(const std::vector<double>& values) {
  return Eigen::Map<const Vector<dim>>(values.data());
}

template <int dim>
SmallCutSettings read_small_cuts(ConfigReader in, const MpmSettings<dim>& mpm) {
  SmallCutSettings settings;
  const std::string word = in.choice("method");
  if (word != "auto") settings.method = small_cut_methods.at(word);
  if (settings.method == SmallCutMethod::ghost && mpm.grid.basis == Basis::bspline) {
    in.fail("method",
            fmt::format("found \"ghost\" with \"basis\": \"{}\", allowed: none, mass_cutoff",
                        basis_name(mpm.grid.basis)));
  }
  const auto used = [&](SmallCutMethod method) {
    return any_has_method(method, settings, mpm.grid.basis, mpm.phases);
  };
  const bool at_rest = std::any_of(mpm.phases.begin(), mpm.phases.end(),
                                   [](const Phase& phase) { return !phase.dynamic; });
  if (used(SmallCutMethod::ghost)) {
    settings.ghost_factor = in.number("ghost_factor");
  } else if (in.has("ghost_factor")) {
    in.fail("ghost_factor", "allowed only with \"method\": \"ghost\"");
  }
  if (at_rest || used(SmallCutMethod::mass_cutoff)) {
    settings.mass_share = in.number("mass_share");
  } else if (in.has("mass_share")) {
    in.fail("mass_share",
            "allowed only with \"method\": \"mass_cutoff\" or \"analysis\": \"quasi_static\"");
  }
  in.finish();
  return settings;
}

// Read the grid: a box of rectangles or bricks is never made into a mesh.
template <int dim>
BackgroundGrid<dim> read_grid(const Scene& scene, ConfigReader in) {
  auto read = read_box_or_mesh<dim>(scene, in);
  if (auto* mesh = std::get_if<Mesh<dim>>(&read)) {
    return BackgroundGrid<dim>(std::move(*mesh));
  }
  const auto& box = std::get<BoxShape<dim>>(read);
  try {
    if (box.cell_type == BoxGrid<dim>::cell_type) {
      return BackgroundGrid<dim>(BoxGrid<dim>(box.low, box.high, box.num_cells));
    }
    return BackgroundGrid<dim>(
        box_mesh<dim>(box.low, box.high, box.num_cells, box.cell_type, box.alternate));
  } catch (const ConfigError& error) {
    in.fail("box/cells", error.what());
  }
}

// Basis of the grid; only cells in rows have a choice. Domains fill a body of boxes or columns.
template <int dim>
Basis read_basis(ConfigReader& in, const BackgroundGrid<dim>& grid,
                 const std::vector<PointLayout<dim>>& layouts) {
  static const std::map<std::string, Basis> bases = {
      {"linear", Basis::linear}, {"gimp", Basis::gimp}, {"bspline", Basis::bspline}};
  const bool in_rows = grid.box.has_value();
  const auto other =
      std::find_if(layouts.begin(), layouts.end(),
                   [](const PointLayout<dim>& layout) { return !has_columns<dim>(layout.mesh); });
  const bool fills = in_rows && other == layouts.end();
  if (in_rows && !fills && !in.has("basis")) {
    log::warn(
        "{}: linear, because cells of /bodies/{}/mesh are not boxes or columns along the axes, as "
        "\"gimp\" needs; linear functions lose volume in tall flows (docs/guide.md)",
        in.where("basis"), other - layouts.begin());
  }
  const std::string name = in.choice_or("basis", fills ? "gimp" : "linear");
  if (name != "linear" && !in_rows) {
    in.fail("basis",
            fmt::format("found \"{}\" on a grid that is not a \"box\" of {}, allowed: linear", name,
                        dim == 2 ? "quad4" : "hex8"));
  }
  return bases.at(name);
}

// Placement of the points of a body. Domains fill the body only around regular points.
template <int dim>
PointPlacement read_placement(ConfigReader& in, const Mesh<dim>& mesh, Basis basis) {
  const bool is_brick = mesh.cell_type == CellType::quad4 || mesh.cell_type == CellType::hex8;
  const bool regular =
      in.choice_or("point_placement", is_brick && basis == Basis::gimp ? "regular" : "gauss") ==
      "regular";
  if (regular && !is_brick) {
    in.fail("point_placement", fmt::format("found \"regular\" on cells of type {}, allowed: gauss",
                                           name(mesh.cell_type)));
  }
  return regular ? PointPlacement::regular : PointPlacement::gauss;
}

// Domains wider than a cell of the grid would be cut at once and leave gaps between the points.
template <int dim>
void check_domains(const ConfigReader& in, const PointLayout<dim>& layout,
                   const Vector<dim>& spacing) {
  MaterialPoints<dim> points;
  lay_points<dim>(layout, 1, {}, points);
  double widest = 0;  // by the spacing
  for (const Vector<dim>& half : points.half_length) {
    widest = std::max(widest, 2 * half.cwiseQuotient(spacing).maxCoeff());
  }
  if (widest <= 1 + 1e-9) return;
  in.fail("points_per_cell",
          fmt::format("found points {:.3g} grid cells wide, allowed with \"basis\": \"gimp\": at "
                      "most 1; give the body more points or smaller cells, or choose another basis",
                      widest));
}

template <int dim>
void read_bodies(const Scene& scene, ConfigReader& in, MpmSettings<dim>& settings) {
  settings.pools = read_pools(in);
  if (auto rain = in.optional_object("rain")) settings.rain = read_rain(std::move(*rain));
  settings.bodies_where = in.where("bodies");
  const Vector<dim> origin = to_vector<dim>(in.vector("origin", dim));
  auto items = in.objects("bodies");
  if (items.empty()) in.fail("bodies", "found an empty list, allowed: at least one body");
  for (auto& item : items) {
    settings.layouts.emplace_back();
    settings.layouts.back().mesh = read_mesh<dim>(scene, item.object("mesh"));
    warn_of_cell_groups(settings.layouts.back().mesh, item.where("mesh"));
  }
  settings.grid.basis = read_basis(in, settings.grid, settings.layouts);
  for (std::size_t b = 0; b < items.size(); ++b) {
    ConfigReader& item = items[b];
    Body<dim> body;
    PointLayout<dim>& layout = settings.layouts[b];
    body.name = item.name("name");
    layout.points_per_cell = item.integer("points_per_cell");
    check_point_rule<dim>(item, "points_per_cell", layout.mesh.cell_type, layout.points_per_cell);
    layout.placement = read_placement(item, layout.mesh, settings.grid.basis);
    layout.with_domains = settings.grid.basis == Basis::gimp;
    if (layout.with_domains) check_domains(item, layout, settings.grid.box->spacing);
    layout.velocity = to_vector<dim>(item.vector("velocity", dim));
    const SourcePlace<dim> place{
        .scene = scene, .body = body.name, .box = box_around(layout.mesh), .origin = origin};
    settings.varying.push_back(
        read_body_material<dim>(item.object("material"), place, b, layout, body));
    settings.initial_stress.emplace_back();
    if (auto water = item.optional_object("water")) {
      body.water =
          read_body_water(std::move(*water), body.material.density, skeleton_modulus(body));
      require_one_stiffness(item, body);
    }
    if (auto stress = item.optional_object("initial_stress")) {
      settings.initial_stress.back() = read_initial_stress<dim>(*stress, body);
      take_water_table<dim>(*stress, layout.mesh, *settings.initial_stress.back(),
                            {settings.pools, 0, 1}, body);
    } else if (std::holds_alternative<CamClay<dim>>(body.material.law)) {
      item.fail(
          "initial_stress",
          "found none with the law cam_clay, allowed: \"initial_stress\" of level ground; this "
          "soil has neither stiffness nor strength without pressure");
    }
    if (auto average = item.optional_object("softening_average")) {
      settings.softening_averages.resize(items.size());
      settings.softening_averages[b] = read_softening_average<dim>(*average, body.material.law);
    }
    item.finish();
    settings.bodies.push_back(std::move(body));
    require_own_name(item, settings.bodies);
  }
}

template <int dim>
bool any_yields(const MpmSettings<dim>& settings) {
  return !std::ranges::all_of(settings.bodies,
                              [](const Body<dim>& body) { return is_elastic(body.material.law); });
}

template <int dim>
void read_transfer(ConfigReader in, MpmSettings<dim>& settings) {
  settings.tpic = in.choice("method") == "tpic";
  for (const char* key : {"pic_share", "noise_damping"}) {
    if (!settings.tpic || !in.has(key)) continue;
    in.fail(key,
            "allowed only with \"method\": \"flip\"; tpic takes the whole velocity "
            "from the grid");
  }
  settings.pic_share = settings.tpic ? 1 : in.number("pic_share");
  if (!settings.tpic) {
    settings.noise_damping =
        in.number_or("noise_damping", any_yields(settings) ? noise_damping_of_soil : 0);
  }
  in.finish();
}

// Read the settings that only a run with inertia has.
template <int dim>
void read_motion(ConfigReader& in, MpmSettings<dim>& settings) {
  const auto& phases = settings.phases;
  const bool any_dynamic =
      std::any_of(phases.begin(), phases.end(), [](const Phase& phase) { return phase.dynamic; });
  if (!any_dynamic && in.has("transfer")) {
    in.fail("transfer", "has no meaning when \"analysis\" is \"quasi_static\"");
  }
  for (std::size_t b = 0; b < settings.layouts.size(); ++b) {
    if (phases.front().dynamic || settings.layouts[b].velocity.isZero(0)) continue;
    in.fail(fmt::format("bodies/{}/velocity", b), "must be zero when the run starts quasi-static");
  }
  if (any_dynamic) read_transfer(in.object("transfer"), settings);
}

// Whether soil is at rest in some part of the run. Then the energy error of CellQuadrature does not
// matter, and the pressure of a cell does.
template <int dim>
bool any_rests(const MpmSettings<dim>& settings) {
  return std::ranges::any_of(settings.initial_stress, &std::optional<InitialStress>::has_value) ||
         std::ranges::any_of(settings.phases, [](const Phase& phase) { return !phase.dynamic; });
}

template <int dim>
Quadrature default_quadrature(const MpmSettings<dim>& settings) {
  if (settings.grid.basis != Basis::linear) return Quadrature::points;
  if (any_yields(settings)) return Quadrature::cells;
  const bool uneven =
      any_rests(settings) && uneven_filling(settings.grid, settings.layouts) > even_filling;
  return uneven ? Quadrature::cells : Quadrature::points;
}

template <int dim>
Quadrature read_quadrature(ConfigReader& in, const MpmSettings<dim>& settings) {
  const bool linear = settings.grid.basis == Basis::linear;
  const Quadrature otherwise =
      in.has("quadrature") ? Quadrature::points : default_quadrature(settings);
  const bool cells = in.choice_or("quadrature", quadrature_name(otherwise)) == "cells";
  if (cells && !linear) {
    in.fail("quadrature", fmt::format("found \"cells\" with \"basis\": \"{}\", allowed: points",
                                      basis_name(settings.grid.basis)));
  }
  return cells ? Quadrature::cells : Quadrature::points;
}

template <int dim>
LockingCure read_locking(ConfigReader in, const MpmSettings<dim>& settings) {
  LockingCure cure = default_locking_cure(settings.bodies);
  const bool given = in.has("method");
  const bool fbar = in.choice_or("method", cure.average_volumes ? "fbar" : "none") == "fbar";
  if (const Body<dim>* wet = fbar ? nullptr : undrained_body(settings.bodies)) {
    in.fail("method",
            fmt::format("found \"none\" with the pore water of \"{}\", allowed: fbar", wet->name));
  }
  in.finish();
  return given ? LockingCure{fbar, "as mpm.json says"} : cure;
}

// Refuse equal names of interfaces and rigid walls: both name files and columns.
template <int dim>
void require_names_apart(const ConfigReader& in, const MpmSettings<dim>& settings) {
  for (std::size_t k = 0; k < settings.rigid_walls.size(); ++k) {
    for (const auto& interface : settings.interfaces) {
      if (settings.rigid_walls[k].name != interface.name) continue;
      in.fail(fmt::format("rigid_walls/{}/name", k),
              fmt::format("found \"{}\", which an interface has, allowed: a name of its own",
                          interface.name));
    }
  }
}

// Read the settings for systems of equations; they are refused where none is solved.
template <int dim>
void read_solvers(ConfigReader& in, MpmSettings<dim>& settings) {
  const char* reason = "has no meaning where all phases are explicit";
  const bool implicit = any_implicit(settings.phases);
  const auto& stresses = settings.initial_stress;
  const bool stressed = std::any_of(stresses.begin(), stresses.end(),
                                    [](const auto& stress) { return stress.has_value(); });
  if (implicit) {
    ConfigReader newton = in.object("newton");
    const bool limited = newton.has("max_iterations");
    settings.newton = read_newton_settings(std::move(newton));
    if (limited) settings.iterations_without_inertia = settings.newton.max_iterations;
  } else if (in.has("newton")) {
    in.fail("newton", reason);
  }
  if (implicit || stressed) {
    settings.linear_solver = read_linear_solver_settings(in.object("linear_solver"));
  } else if (in.has("linear_solver")) {
    in.fail("linear_solver", reason);
  }
}

// Refuse phases whose ends no step of the raster reaches.
void require_on_raster(const ConfigReader& in, const std::vector<Phase>& phases,
                       const TimeSettings& time) {
  double smallest = time.dt;
  while (smallest / 2 >= time.dt_min) smallest /= 2;
  for (std::size_t k = 0; k + 1 < phases.size(); ++k) {
    const double steps = phases[k].until / smallest;
    if (std::abs(steps - std::round(steps)) <= 1e-9 * steps) continue;
    in.fail(
        fmt::format("phases/{}/until", k),
        fmt::format("found {}, allowed: a multiple of time/dt = {} or of its half, quarter, ... "
                    "down to time/dt_min",
                    phases[k].until, time.dt));
  }
}
}  // namespace

template <int dim>
MpmSettings<dim> read_mpm_settings(const Scene& scene, ConfigReader& in, AloneSettings* alone) {
  MpmSettings<dim> settings;
  settings.grid = read_grid<dim>(scene, in.object("grid"));
  settings.phases = read_phases(in, dim);
  check_grid_mesh(in, settings.grid, settings.phases);
  read_bodies<dim>(scene, in, settings);
  settings.gravity = to_vector<dim>(in.vector("gravity", dim));
  for (auto& body : settings.bodies) {
    if (body.water) body.water->specific_weight = body.water->density * settings.gravity.norm();
  }
  read_motion(in, settings);
  settings.quadrature = read_quadrature(in, settings);
  settings.locking = read_locking(in.object("locking"), settings);
  settings.small_cuts = read_small_cuts(in.object("small_cuts"), settings);
  read_solvers(in, settings);
  if (auto item = in.optional_object("step_control")) {
    settings.step_control = read_step_control(*item, any_implicit(settings.phases));
  }
  double modulus = 0;
  for (const auto& body : settings.bodies) modulus = std::max(modulus, skeleton_modulus(body));
  require_no_snap_back(settings);
  const double penalty_unit = modulus / mean_cell_size(settings.grid);
  settings.interfaces = read_interfaces<dim>(scene, in, penalty_unit);
  settings.rigid_walls = read_rigid_walls<dim>(scene, in, penalty_unit);
  require_names_apart(in, settings);
  std::vector<std::string> bodies;
  for (const auto& body : settings.bodies) bodies.push_back(body.name);
  settings.body_groups = read_body_groups(in, bodies);
  check_group_needs(in, settings);
  check_phase_needs(in, settings);
  check_seepage(in, settings);
  std::vector<std::string> walls;
  for (const auto& wall : settings.rigid_walls) walls.push_back(wall.name);
  resolve_rigid_walls(in, walls, settings.phases);
  read_boulders<dim>(scene, in, boulder_scene<dim>(settings, settings.grid), settings.boulders,
                     settings.rigid_walls);
  check_pools(in, settings);
  const bool meets =
      !settings.interfaces.empty() || !settings.rigid_walls.empty() || settings.body_groups.any();
  for (const Phase& phase : settings.phases) {
    if (meets) require_balance_at_end_of_step(in, phase.scheme);
  }
  for (auto& item : in.objects("probes")) {
    settings.probes.push_back({item.name("name"), to_vector<dim>(item.vector("point", dim))});
    item.finish();
    require_own_name(item, settings.probes);
  }
  settings.gauges = read_gauges<dim>(in, bounding_box(settings.grid));
  settings.outside = in.choice("outside") == "remove" ? Outside::remove : Outside::error;
  if (alone) {
    *alone = read_alone_settings(in);
    require_on_raster(in, settings.phases, alone->time);
  }
  if (in.has("$schema")) in.text("$schema");
  in.finish();
  warn_of_implausible_settings(in, Described::soil);
  return settings;
}

template MpmSettings<2> read_mpm_settings<2>(const Scene&, ConfigReader&, AloneSettings*);
template MpmSettings<3> read_mpm_settings<3>(const Scene&, ConfigReader&, AloneSettings*);

}  // namespace gabion::mpm
