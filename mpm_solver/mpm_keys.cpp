// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include "mpm_solver/boulders/boulder_config.hpp"
#include "mpm_solver/boulders/random_boulder_config.hpp"
#include "mpm_solver/contact/contact_keys.hpp"
#include "mpm_solver/contact/group_config.hpp"
#include "mpm_solver/gauges/gauge_config.hpp"
#include "mpm_solver/mpm_config.hpp"
#include "mpm_solver/points/rain.hpp"
#include "mpm_solver/stress/softening_average_config.hpp"

namespace gabion::mpm {

namespace {

KeyTable body_keys() {
  return {
      "body",
      "Soil of one material. Its mesh gives shape and material points only.",
      {key::plain_name("Name of the body, unique."),
       key::object("mesh", mesh_keys(), "Shape at the start."),
       key::integer(
           "points_per_cell",
           "Material points of a cell: tri3 1, 3, 4, 6, 12 or 16; quad4 1, 4, 9 or 16; tet4 1 "
           "or 4; hex8 1, 8 or 27.")
           .in(at_least(1)),
       key::choice("point_placement", {"gauss", "regular"},
                   "Places of the material points. `gauss`: Gauss points; `regular`: centres "
                   "of equal parts of a quad4 or hex8.")
           .or_computed("`regular` with `basis` `gimp` in quad4 and hex8, else `gauss`"),
       key::vector("velocity", "m/s", "Initial velocity; zero where the run starts quasi-static.")
           .or_else(0),
       key::object("material", varying_material_keys(material_laws), "Law and constants."),
       key::object("water", body_water_keys(), "Pore water; none: dry.").or_none(),
       key::object("initial_stress", initial_stress_keys(),
                   "Geostatic stress at the start; none: free of stress.")
           .or_none(),
       key::object("softening_average", softening_average_keys(),
                   "Softening by the mean slip of a point's surroundings; none: shear bands "
                   "are as narrow as the cells make them.")
           .or_none()}};
}

KeyTable transfer_keys() {
  return {"transfer",
          "How velocities go from the grid back to the material points.",
          {key::choice("method", {"flip", "tpic"},
                       "`flip`: the change of velocity; `tpic`: the velocity, with gradients.")
               .or_else("flip"),
           key::number("pic_share", "", "Share of PIC in the velocity: 0 is FLIP, 1 PIC.")
               .in(between(0, 1))
               .or_else(0)
               .when("method", {"flip"}),
           key::number("noise_damping", "",
                       "Damping of velocities that vary within a cell, in all bodies, where the "
                       "soil does not flow. They decay by exp(-noise_damping) in the time in which "
                       "a wave of speed sqrt(stress / density) crosses a cell.")
               .in(at_least(0))
               .or_computed(fmt::format("{:g} where a body yields, else 0", noise_damping_of_soil))
               .when("method", {"flip"})}};
}

KeyTable locking_keys() {
  return {"locking",
          "Remedy for volumetric locking.",
          {key::choice("method", {"fbar", "none"},
                       "`fbar`: points of a cell (tri3, tet4: of a patch) share their change of "
                       "volume.")
               .or_computed(fmt::format(
                   "`fbar` when a body has a law that yields or `poisson_ratio` > {}, else `none`",
                   locking_poisson_ratio))}};
}

KeyTable small_cut_keys() {
  const SmallCutSettings defaults;
  return {"small_cuts",
          "Remedy for cells and nodes that hold little soil.",
          {key::choice(
               "method", {"auto", "none", "ghost", "mass_cutoff"},
               "`auto`: `ghost` in quasi-static phases with `linear` or `gimp`, else `none`; "
               "another word holds for all phases, `ghost` not with `bspline`. Unless `none` is "
               "given, one more remedy acts on triangles and tetrahedra with soil that yields: "
               "nodes behind a surface that cuts their cells join a node in front of it where "
               "little soil holds them.")
               .or_else("auto"),
           key::number("ghost_factor", "", "Ghost stiffness over Young's modulus.")
               .in(positive())
               .or_else(defaults.ghost_factor)
               .only("where a phase has `ghost`"),
           key::number("mass_share", "",
                       "A node joins another where its mass is below this share of the mass of the "
                       "points around it.")
               .in({.low = 0, .high = 0.01, .low_open = true, .allowed = "a number in (0, 0.01]"})
               .or_else(defaults.mass_share)
               .only("where a phase is quasi-static or has `mass_cutoff`")}};
}

KeyTable probe_keys() {
  return {
      "probe",
      "A point whose motion is reported: that of the material point nearest to it at the start.",
      {key::plain_name("Unique name; columns of the tables start with it."),
       key::vector("point", "m", "At the start.")}};
}

constexpr const char* default_quadrature_words =
    "`cells` with `linear` where a body yields, and where soil at rest (`initial_stress`, "
    "`quasi_static`) does not fill the cells of the grid evenly; else `points`";

std::vector<Key> model_keys() {
  return {key::integer("dimension", "Dimension of space; 2 is plane strain.").in(between(2, 3)),
          key::object("grid", mesh_keys(), "Background grid."),
          key::choice("basis", {"linear", "gimp", "bspline"},
                      "Basis functions of the grid; the last two need a `box` of quad4 or hex8.")
              .or_computed("`gimp` where the grid is such a box and all cells of the bodies are "
                           "boxes or upright columns of quad4 or hex8, else `linear`"),
          key::choice("quadrature", {"cells", "points"},
                      fmt::format("How the stresses of a cell are integrated. `points`: over its "
                                  "material points; `cells` (with `linear` only): over the cell "
                                  "itself where it lies inside the soil, with all neighbours "
                                  "filled by {:g} or more.",
                                  least_filling))
              .or_computed(default_quadrature_words),
          key::vector("origin", "m",
                      "World coordinates of the scene's zero point, such as those of a map. "
                      "Rasters and exported results use them; the run itself uses local "
                      "coordinates.")
              .or_else(0),
          key::objects("bodies", body_keys(), "The soil.").not_empty(),
          key::object("contact_groups", contact_group_keys(),
                      "Bodies that have nodes of their own and meet by contact, on a `box` grid of "
                      "quad4 or hex8; none: all bodies share the nodes, and stick to each other.")
              .or_none(),
          key::vector("gravity", "m/s^2", "Acceleration on all material points.").or_else(0),
          key::objects("pools", pool_keys(),
                       "Free water at rest over the soil, in the order of x; all bodies must have "
                       "water that drains.")
              .or_empty(),
          key::object("rain", rain_keys(),
                      "Rain on soil whose pore water drains through its `free_surface`; none: it "
                      "does not rain.")
              .or_none(),
          key::choice("outside", {"error", "remove"},
                      "Material points that leave the grid: the step fails, or they are taken out.")
              .or_else("error"),
          key::object("transfer", transfer_keys(),
                      "How velocities go from the grid back to the "
                      "material points.")
              .or_empty()
              .only("where a phase has inertia"),
          key::object("locking", locking_keys(), "Remedy for volumetric locking.").or_empty(),
          key::object("small_cuts", small_cut_keys(), "Remedy for small cut cells.").or_empty()};
}

KeyTable soil_newton_keys() {
  const MpmSettings<2> defaults;
  KeyTable table = newton_keys(defaults.newton);
  for (Key& key : table.keys) {
    if (key.name != "max_iterations") continue;
    key.sentence += fmt::format(" Where it is not given, steps without inertia may take {}.",
                                defaults.iterations_without_inertia);
  }
  return table;
}

std::vector<Key> surface_and_solver_keys() {
  return {key::objects("interfaces", interface_keys(), "Coupled surfaces.").or_empty(),
          key::objects("rigid_walls", rigid_wall_keys(), "Surfaces at rest or with a given motion.")
              .or_empty(),
          key::objects("boulders", boulder_keys(), "Rigid bodies that move freely.").or_empty(),
          key::objects("random_boulders", random_boulder_keys(), "Boulders at random places.")
              .or_empty(),
          key::objects("probes", probe_keys(), "Points whose motion is reported.").or_empty(),
          key::objects("gauges", gauge_keys(),
                       "Pieces of planes through which the flow of soil is measured.")
              .or_empty(),
          key::object("newton", soil_newton_keys(), "Newton's method.")
              .or_empty()
              .only("where a phase is implicit"),
          key::object("linear_solver", linear_solver_keys(), "Solution of the linear systems.")
              .or_empty()
              .only("where a phase is implicit or a body has initial stress"),
          key::object("step_control", step_control_keys(), "Limits of dt; none: no limit acts.")
              .or_none()};
}

}  // namespace

KeyTable mpm_keys() {
  KeyTable table{"mpm", "Settings of the soil.", {key::schema()}};
  for (const auto& group : {model_keys(), phases_keys(), surface_and_solver_keys(), alone_keys()}) {
    table.keys.insert(table.keys.end(), group.begin(), group.end());
  }
  return table;
}

}  // namespace gabion::mpm
