// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/checks/seepage.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <variant>

#include "mpm_solver/grid/basis.hpp"
#include "mpm_solver/points/retention.hpp"

namespace gabion::mpm {

namespace {

// Relative error of equal lengths.
constexpr double rounding = 1e-9;

std::string key_of(std::size_t body) {
  return fmt::format("bodies/{}/water/permeability", body);
}

// Refuse a basis or points a cell with which the stabilisation cannot tell the pressures of a cell
// apart.
template <int dim>
void check_layout(const ConfigReader& in, const MpmSettings<dim>& settings, std::size_t b) {
  if (!settings.grid.box || settings.grid.basis == Basis::linear) {
    in.fail(key_of(b), fmt::format("found on a grid with {}, allowed: a \"box\" of {} with "
                                   "\"basis\": \"gimp\" or \"bspline\"",
                                   settings.grid.box ? "\"basis\": \"linear\"" : "a mesh",
                                   dim == 2 ? "quad4" : "hex8"));
  }
  constexpr int fewest = 1 << dim;
  if (settings.layouts[b].points_per_cell < fewest) {
    in.fail(fmt::format("bodies/{}/points_per_cell", b),
            fmt::format("found {} with \"permeability\", allowed: at least {}; the pressure of the "
                        "water would alternate from cell to cell",
                        settings.layouts[b].points_per_cell, fewest));
  }
}

// Longest side of the cells by their shortest, both by the spacing of the grid.
template <int dim>
double slenderness(const Mesh<dim>& mesh, const BoxGrid<dim>& grid) {
  double largest = 1;
  for (std::int32_t c = 0; c < mesh.num_cells(); ++c) {
    Vector<dim> low = mesh.nodes[mesh.cell(c)[0]], high = low;
    for (const std::int32_t node : mesh.cell(c)) {
      low = low.cwiseMin(mesh.nodes[node]);
      high = high.cwiseMax(mesh.nodes[node]);
    }
    const Vector<dim> sides = (high - low).cwiseQuotient(grid.spacing);
    largest = std::max(largest, sides.maxCoeff() / sides.minCoeff());
  }
  return largest;
}

// Refuse points that are much farther apart along one axis than along another: the search for the
// soil's surface would find no neighbours.
template <int dim>
void check_cells(const ConfigReader& in, const MpmSettings<dim>& settings, std::size_t b) {
  const Mesh<dim>& mesh = settings.layouts[b].mesh;
  if (!settings.bodies[b].water->seepage_face || is_simplex(mesh.cell_type)) return;
  constexpr double most = dim == 2 ? 4 : 3;
  const double found = slenderness(mesh, *settings.grid.box);
  if (found <= most * (1 + rounding)) return;
  in.fail(fmt::format("bodies/{}/mesh", b),
          fmt::format("found cells with sides of 1 to {:g}, by the spacing of the grid, with "
                      "\"free_surface\" \"seepage_face\", allowed: up to 1 to {:g}; the soil's "
                      "surface is found from its points",
                      found, most));
}

// Check that all pores are full (the table is not below the top of the body) and that there is one
// table.
template <int dim>
void check_start(const ConfigReader& in, const MpmSettings<dim>& settings, std::size_t b) {
  const auto& stress = settings.initial_stress[b];
  if (!stress || !stress->water_table) return;
  const double table = *stress->water_table;
  const bool flows = stress->steady_seepage;
  const std::string where = fmt::format("bodies/{}/initial_stress/water_table", b);
  double top = -std::numeric_limits<double>::infinity(), size = 0;
  for (const auto& x : settings.layouts[b].mesh.nodes) {
    top = std::max(top, x[dim - 1]);
    size = std::max(size, (x - settings.layouts[b].mesh.nodes.front()).norm());
  }
  if (table < top - rounding * size && !flows) {
    in.fail(where,
            fmt::format("found {:g} with \"permeability\", allowed: at least {:g}, the top of "
                        "the body; soil above the table is another body, without \"water\"",
                        table, top));
  }
  for (std::size_t other = 0; other < b; ++other) {
    const auto& own = settings.initial_stress[other];
    if (!drains(settings.bodies[other]) || !own || !own->water_table) continue;
    if (std::abs(*own->water_table - table) <= rounding * size) continue;
    in.fail(where,
            fmt::format("found {:g} where \"{}\" has {:g}, allowed with \"permeability\": one "
                        "water table",
                        table, settings.bodies[other].name, *own->water_table));
  }
}

template <int dim>
bool starts_in_flow(const MpmSettings<dim>& settings, std::size_t b) {
  return settings.initial_stress[b] && settings.initial_stress[b]->steady_seepage;
}

// Check that the water of this body and that of the first one that drains both flow at the start,
// or neither.
template <int dim>
void check_flow(const ConfigReader& in, const MpmSettings<dim>& settings, std::size_t first,
                std::size_t b) {
  const bool flows = starts_in_flow(settings, b);
  if (flows == starts_in_flow(settings, first)) return;
  in.fail(fmt::format("bodies/{}/initial_stress/pore_pressure", b),
          fmt::format("found {} where \"{}\" has {}, allowed: \"steady_seepage\" of all bodies "
                      "whose water drains, or of none",
                      flows ? "\"steady_seepage\"" : "another start", settings.bodies[first].name,
                      flows ? "another start" : "\"steady_seepage\""));
}

// Check that cells resolve the pressure between full pores and those that air has entered.
template <int dim>
void check_suction(const ConfigReader& in, const MpmSettings<dim>& settings, std::size_t b) {
  const PoreWater& water = *settings.bodies[b].water;
  const double of_half_cell =
      0.5 * water.density * settings.gravity.norm() * settings.grid.box->spacing.minCoeff();
  if (!gives_way(water) || water.cavitation >= of_half_cell) return;
  in.fail(fmt::format("bodies/{}/water/suction_limit", b),
          fmt::format("found {:g}, allowed: at least {:.4g} Pa, that of half a cell of the grid; "
                      "smaller cells, or a limit that they see",
                      water.cavitation, of_half_cell));
}

// Refuse iterative solvers: the matrix is indefinite, and none of them solves it.
template <int dim>
void check_linear_solver(const ConfigReader& in, const MpmSettings<dim>& settings) {
  const std::string& method = settings.linear_solver.method;
  if (method == "auto" || method == "lu" || method == "mumps") return;
  in.fail("linear_solver/method",
          fmt::format("found \"{}\" with \"permeability\", allowed: auto, lu, mumps", method));
}

// Refuse an inflow through walls that no soil takes in, and where its area is not known.
template <int dim>
void check_inflow(const MpmSettings<dim>& settings) {
  const bool any_drains = std::ranges::any_of(settings.bodies, drains<dim>);
  for (const Phase& phase : settings.phases) {
    for (const WallSettings& wall : phase.walls) {
      if (wall.inflow == 0) continue;
      const auto refuse = [&wall](const char* found, const char* allowed) {
        throw ConfigError(fmt::format("{}: found {:g} {}, allowed: {}", wall.where_inflow,
                                      wall.inflow, found, allowed));
      };
      if (!any_drains) {
        refuse("without soil whose water drains",
               "with a body that has \"water\" with \"permeability\"");
      }
      if (phase.is_explicit()) refuse("in a phase with explicit steps", "implicit steps");
      if (settings.grid.basis != Basis::gimp) {
        refuse("with \"basis\" \"bspline\", whose points have no sides", "\"basis\": \"gimp\"");
      }
    }
  }
}

template <int dim>
void check_density(const ConfigReader& in, const MpmSettings<dim>& settings, std::size_t first,
                   std::size_t b) {
  const double expected = settings.bodies[first].water->density;
  const double found = settings.bodies[b].water->density;
  if (found == expected) return;
  in.fail(fmt::format("bodies/{}/water/density", b),
          fmt::format("found {:g} where the water of \"{}\" has {:g}, allowed with "
                      "\"permeability\": one density",
                      found, settings.bodies[first].name, expected));
}

// Refuse what the fractional step cannot do as yet.
template <int dim>
void check_fractional_step(const ConfigReader& in, const MpmSettings<dim>& settings) {
  if (!any_explicit(settings.phases)) return;
  constexpr const char* found =
      "found with \"permeability\" and explicit steps, allowed: implicit steps";
  for (std::size_t b = 0; b < settings.bodies.size(); ++b) {
    const auto& water = settings.bodies[b].water;
    if (water && gives_way(*water)) {
      in.fail(fmt::format("bodies/{}/water/suction_limit", b), found);
    }
  }
}

void check_phases(const ConfigReader& in, const std::vector<Phase>& phases, std::size_t first) {
  for (const Phase& phase : phases) {
    if (phase.dynamic && phase.scheme.force_memory() != 0) {
      in.fail(key_of(first),
              "found with a scheme that averages forces (alpha_f), allowed: newmark, bossak");
    }
  }
}

// Check that drained surfaces have soil with a seepage face, in every body, since any body may come
// to them.
template <int dim>
void check_drained_surface(const MpmSettings<dim>& settings, const ContactSettings<dim>& surface) {
  if (!surface.drained) return;
  constexpr const char* allowed =
      "allowed: with \"water\" with \"permeability\" and \"free_surface\" \"seepage_face\"";
  if (std::ranges::none_of(settings.bodies, drains<dim>)) {
    throw ConfigError(fmt::format(
        "{}: found the surface of \"{}\" \"drained\" without soil whose water drains, {}",
        surface.where, surface.name, allowed));
  }
  for (const Body<dim>& body : settings.bodies) {
    if (!drains(body) || body.water->seepage_face) continue;
    throw ConfigError(
        fmt::format("{}: found the surface of \"{}\" \"drained\" beside the body \"{}\" with "
                    "\"free_surface\" \"impervious\", {} for all bodies whose water drains",
                    surface.where, surface.name, body.name, allowed));
  }
}

// Refuse boundary points: they have no facets that the soil could end at, so water would leave
// through them.
template <int dim>
void check_boundary_points(const MpmSettings<dim>& settings, const ContactSettings<dim>& surface) {
  if (!std::holds_alternative<BoundaryPointSettings>(surface.method)) return;
  for (const Body<dim>& body : settings.bodies) {
    if (!drains(body) || !body.water->seepage_face) continue;
    throw ConfigError(
        fmt::format("{}: found the surface of \"{}\" with \"method\" \"boundary_points\" beside "
                    "the body \"{}\", whose water would leave through it, allowed: \"method\" "
                    "\"facets\", or \"free_surface\" \"impervious\" for the water of the body",
                    surface.where, surface.name, body.name));
  }
}

template <int dim>
void check_surfaces(const MpmSettings<dim>& settings) {
  const auto check = [&](const ContactSettings<dim>& surface) {
    check_drained_surface(settings, surface);
    check_boundary_points(settings, surface);
  };
  for (const auto& surface : settings.interfaces) check(surface);
  for (const auto& wall : settings.rigid_walls) check(wall.boundary);
}

// Check that there is soil that can take rain in, and a direction of gravity.
template <int dim>
void check_rain(const ConfigReader& in, const MpmSettings<dim>& settings) {
  if (!settings.rain) return;
  if (settings.gravity.isZero(0)) {
    in.fail("rain", "found without \"gravity\", allowed: with it; rain falls along it");
  }
  const auto takes_rain = [](const Body<dim>& body) {
    return drains(body) && body.water->seepage_face;
  };
  if (std::ranges::any_of(settings.bodies, takes_rain)) return;
  in.fail("rain",
          "found without soil that takes it in, allowed: with a body that has \"water\" with "
          "\"permeability\" and \"free_surface\" \"seepage_face\"; other water stays with its "
          "grains");
}

}  // namespace

template <int dim>
void check_seepage(const ConfigReader& in, const MpmSettings<dim>& settings) {
  std::optional<std::size_t> first;
  for (std::size_t b = 0; b < settings.bodies.size(); ++b) {
    if (!drains(settings.bodies[b])) continue;
    if (!first) first = b;
    check_layout(in, settings, b);
    check_cells(in, settings, b);
    check_start(in, settings, b);
    check_flow(in, settings, *first, b);
    check_suction(in, settings, b);
    check_density(in, settings, *first, b);
  }
  check_surfaces(settings);
  check_rain(in, settings);
  check_inflow(settings);
  if (first) {
    check_phases(in, settings.phases, *first);
    check_fractional_step(in, settings);
    check_linear_solver(in, settings);
    return;
  }
  for (const Phase& phase : settings.phases) {
    for (const WallSettings& wall : phase.walls) {
      if (!wall.drained) continue;
      throw ConfigError(
          fmt::format("{}: found a wall that is \"drained\" without soil whose water drains, "
                      "allowed: with a body that has \"water\" with \"permeability\"",
                      wall.where));
    }
  }
}

template <int dim>
const Body<dim>* undrained_body(const std::vector<Body<dim>>& bodies) {
  const auto body = std::ranges::find_if(
      bodies, [](const Body<dim>& each) { return each.water && !each.water->drains(); });
  return body == bodies.end() ? nullptr : &*body;
}

template const Body<2>* undrained_body<2>(const std::vector<Body<2>>&);
template const Body<3>* undrained_body<3>(const std::vector<Body<3>>&);
template void check_seepage<2>(const ConfigReader&, const MpmSettings<2>&);
template void check_seepage<3>(const ConfigReader&, const MpmSettings<3>&);

}  // namespace gabion::mpm
