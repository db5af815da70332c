// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/contact/contact_keys.hpp"

#include "mpm_solver/contact/rigid_motion.hpp"
#include "mpm_solver/contact/surface_config.hpp"

namespace gabion::mpm {

namespace {

Key resting_factor_key() {
  return key::number(
             "resting_factor", "",
             "Stiffness of contact points that form while soil takes its weight (in quasi-static "
             "steps or during a `gravity_ramp`), times the mean cell size over the P-wave modulus. "
             "It acts at the pressure under the body's own weight and above, as long as the "
             "contact lasts. With 12, the thrust between walls 16 cells apart is at most 3 % too "
             "small. 0: the stiffness is that of `penalty_factor`. Stiff soil then finds little "
             "thrust after a ramp, but coupling with a structure as soft as the soil takes fewer "
             "iterations.")
      .in(non_negative())
      .or_computed("12 of a rigid wall, 0 of an interface")
      .when("method", {"facets"});
}

Key turbulent_drag_key() {
  return key::number("turbulent_drag", "Pa s^2/m^2",
                     "Shear stress over the square of the sliding speed, added to `friction`: rho "
                     "g / xi of Voellmy.")
      .in(non_negative())
      .or_else(0)
      .when("mode", {"contact"})
      .when("method", {"facets"})
      .with("friction");
}

Key friction_key() {
  return key::number("friction", "",
                     "Coefficient of friction; none: soil sticks, with `facets` by a coefficient "
                     "of 100, so that forces do not jump where it separates.")
      .in(non_negative())
      .or_none()
      .when("mode", {"contact"});
}

Key friction_at_speed_key() {
  return key::number("friction_at_speed", "",
                     "Coefficient to which friction falls as soil slides faster, at most "
                     "`friction`; none: friction does not depend on the speed.")
      .in(non_negative())
      .or_none()
      .when("mode", {"contact"})
      .when("method", {"facets"})
      .with("friction");
}

Key weakening_speed_key() {
  return key::number("weakening_speed", "m/s",
                     "Sliding speed v_c at which 1 - 1/e of that fall is reached: "
                     "`friction_at_speed` + (`friction` - `friction_at_speed`) exp(-v / v_c).")
      .in(positive())
      .with("friction_at_speed");
}

Key drained_key() {
  return key::boolean(
             "drained",
             "Whether pore water leaves the soil there as into air (`seepage_face` of "
             "`free_surface`): a net, a rack, a wall with a filter. Only with soil that has a "
             "`permeability` and such a surface.")
      .or_else(false)
      .when("method", {"facets"});
}

std::vector<Key> boundary_keys() {
  return {
      key::object("surface", surface_keys(), "Surface that the soil meets."),
      key::choice(
          "mode", {"fixed", "contact", "slip"},
          "`contact`: pushes, never pulls, and sticks or slides by `friction`; `slip`: pushes "
          "in normal direction only; `fixed`: holds in all directions, in tension too, by the "
          "method "
          "`boundary_points`.")
          .or_else("contact"),
      key::choice(
          "method", {"boundary_points", "facets"},
          "`facets`: contact between material points and the facets of the surface, by their "
          "distance; `boundary_points`: points on the surface that hold the grid from the moment "
          "soil enters their cell.")
          .or_else("facets"),
      key::choice(
          "gap", {"accumulated", "step"},
          "What the penalty acts on: `accumulated`: the gap since soil came near; `step`: the "
          "displacement of this step only.")
          .or_else("accumulated")
          .when("method", {"boundary_points"}),
      key::number("penalty", "Pa/m", "Traction over penetration.")
          .in(positive())
          .or_none()
          .when("method", {"boundary_points"}),
      key::number(
          "penalty_factor", "",
          "With `facets`: traction at a penetration of one cell size, over the P-wave modulus of "
          "the body; it grows with the square of the penetration. With `boundary_points`: penalty "
          "times the mean cell size, over the largest such modulus.")
          .in(positive())
          .or_computed("10; 0.5 with `boundary_points`")
          .without("penalty"),
      resting_factor_key(),
      friction_key(),
      friction_at_speed_key(),
      weakening_speed_key(),
      turbulent_drag_key(),
      key::number("tangential_factor", "",
                  "Tangential stiffness times the mean cell size over the P-wave modulus of the "
                  "body.")
          .in(positive())
          .or_else(0.25)
          .when("method", {"facets"}),
      key::number("tangential_share", "", "Tangential over normal penalty.")
          .in(between(1e-6, 1))
          .or_computed("1; with `friction` 0.1")
          .when("method", {"boundary_points"}),
      key::integer("points_per_facet",
                   "Boundary points per facet: any number on a segment; 1, 3, 4, 6, 12 or 16 on a "
                   "triangle; 1, 4, 9 or 16 on a quadrilateral; at most 1 000 000 in all.")
          .in(at_least(1))
          .or_computed("number of its vertices")
          .when("method", {"boundary_points"})};
}

KeyTable with_boundary(KeyTable table) {
  for (const Key& key : boundary_keys()) table.keys.push_back(key);
  table.keys.push_back(drained_key());
  return table;
}

}  // namespace

KeyTable interface_keys() {
  return with_boundary({"interface",
                        "A surface that the coupler moves and that receives the force of the soil.",
                        {key::plain_name("As in coupler.json.")}});
}

KeyTable rigid_wall_keys() {
  KeyTable table =
      with_boundary({"rigid_wall",
                     "A surface at rest or with a given motion, whatever the soil does.",
                     {key::plain_name("Unique name; columns of the tables start with it.")}});
  table.keys.push_back(
      key::object("motion", rigid_motion_keys(), "Given motion; none: it is at rest.").or_none());
  table.keys.push_back(
      key::vector("moment_about", "m", "Point about which the moment on the wall is given.")
          .or_else(0));
  return table;
}

}  // namespace gabion::mpm
