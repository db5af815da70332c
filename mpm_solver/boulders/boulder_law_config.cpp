// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/boulders/boulder_law_config.hpp"

#include <fmt/format.h>

#include <cmath>

#include "mpm_solver/boulders/impact_damping.hpp"
#include "mpm_solver/contact/sticking.hpp"

namespace gabion::mpm {

namespace {

// The default stiffness stops a sphere that hits a wall at this speed [m/s] within this share of
// its radius.
constexpr double usual_speed = 10, usual_depth = 0.01;

// A flat ellipsoid may be no deeper than its smallest semi-axis allows.
template <int dim>
double smallest_radius(const BoulderShape<dim>& shape) {
  const bool is_ellipsoid = shape.axes[0] > 0;
  return is_ellipsoid ? shape.radius * (shape.axes.minCoeff() / shape.axes.maxCoeff())
                      : shape.radius;
}

}  // namespace

std::vector<Key> boulder_law_keys() {
  return {
      key::number("density", "kg/m^3", "Density of the rock.").in(positive()),
      key::vector("velocity", "m/s", "Initial velocity.").or_else(0),
      key::number("friction", "", "Coefficient of friction on hard bodies.")
          .in(non_negative())
          .or_else(0.5),
      key::number("soil_friction", "",
                  "Coefficient of friction between soil and boulder; none: soil sticks.")
          .in(non_negative())
          .or_none(),
      key::choice("soil_inside", {"error", "remove"},
                  "Material points that lie in the boulder at the start, with their centre or with "
                  "a twentieth of the radius of their contact sphere. `error`: they are refused; "
                  "`remove`: they are left out, and a gap of up to half a point's width surrounds "
                  "the boulder.")
          .or_else("error"),
      key::number("restitution", "",
                  fmt::format("Normal speed after an impact on a hard body over the speed before "
                              "it; on an interface a value below {0} acts as {0}.",
                              least_damped_restitution))
          .in(between(0, 1))
          .or_else(0.4),
      key::number("rolling_resistance", "",
                  "Largest resisting moment over radius times normal force; for spheres only.")
          .in(non_negative())
          .or_else(0),
      key::number("free_from", "s",
                  "Time before which the boulder is held: in all steps that begin earlier.")
          .in(non_negative())
          .or_else(0)};
}

template <int dim>
void read_boulder_law(ConfigReader& in, BoulderSettings<dim>& boulder) {
  boulder.law.friction = in.number("friction");
  boulder.law.restitution = in.number("restitution");
  boulder.law.rolling = in.number("rolling_resistance");
  if (boulder.shape.sphere == 0 && boulder.law.rolling > 0) {
    in.fail("rolling_resistance", fmt::format("found {} with a shape that is no sphere, allowed: 0",
                                              boulder.law.rolling));
  }
  boulder.soil_friction = in.has("soil_friction") ? in.number("soil_friction") : sticking;
  boulder.removes_soil = in.choice("soil_inside") == "remove";
  boulder.free_from = in.number("free_from");
}

template <int dim>
double usual_stiffness(const BoulderShape<dim>& shape) {
  return 1.5 * shape.mass.mass * usual_speed * usual_speed /
         std::pow(usual_depth * smallest_radius(shape), 3);
}

std::string usual_stiffness_words() {
  return fmt::format(
      "stops {:g} m/s within {:g} of the radius, of an ellipsoid of its smallest "
      "semi-axis",
      usual_speed, usual_depth);
}

template void read_boulder_law<2>(ConfigReader&, BoulderSettings<2>&);
template void read_boulder_law<3>(ConfigReader&, BoulderSettings<3>&);
template double usual_stiffness<2>(const BoulderShape<2>&);
template double usual_stiffness<3>(const BoulderShape<3>&);

}  // namespace gabion::mpm
