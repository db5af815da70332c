// SPDX-License-Identifier: BSD-3-Clause
#include "fem_solver/beams/cross_section.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

namespace gabion::fem {

namespace {

/// Corners of an octagon inside a circle [m].
std::vector<Vector<2>> octagon(double radius) {
  std::vector<Vector<2>> corners;
  for (int k = 0; k < 8; ++k) {
    const double angle = k * std::numbers::pi / 4;
    corners.emplace_back(radius * std::cos(angle), radius * std::sin(angle));
  }
  return corners;
}

}  // namespace

bool CrossSection::is_round() const {
  return moments[0] == moments[1] && shear_areas[0] == shear_areas[1];
}

CrossSection CrossSection::over(double spacing) const {
  std::vector<Fibre> shared = fibres;
  for (Fibre& fibre : shared) fibre.area /= spacing;
  return {.area = area / spacing,
          .shear_areas = {shear_areas[0] / spacing, shear_areas[1] / spacing},
          .moments = {moments[0] / spacing, moments[1] / spacing},
          .torsion_constant = torsion_constant / spacing,
          .outline = outline,
          .fibres = std::move(shared)};
}

CrossSection rectangle_section(double height, double width, double poisson_ratio, int dim) {
  const double nu = poisson_ratio, area = height * width;
  const double shear = 10 * (1 + nu) / (12 + 11 * nu) * area;  // Cowper 1966
  const double a = std::max(height, width), b = std::min(height, width), ratio = b / a;
  const double torsion = a * b * b * b * (1.0 / 3 - 0.21 * ratio * (1 - std::pow(ratio, 4) / 12));
  return {.area = area,
          .shear_areas = {shear, shear},
          .moments = {height * std::pow(width, 3) / 12, width * std::pow(height, 3) / 12},
          .torsion_constant = torsion,
          .outline = {{height / 2, width / 2},
                      {-height / 2, width / 2},
                      {-height / 2, -width / 2},
                      {height / 2, -width / 2}},
          .fibres = rectangle_fibres(height, width, dim)};
}

CrossSection ring_section(double diameter, double inner, double poisson_ratio) {
  const double nu = poisson_ratio, m = inner / diameter, square = (1 + m * m) * (1 + m * m);
  const double area = std::numbers::pi / 4 * (diameter * diameter - inner * inner);
  const double I = std::numbers::pi / 64 * (std::pow(diameter, 4) - std::pow(inner, 4));
  const double shear =
      6 * (1 + nu) * square / ((7 + 6 * nu) * square + (20 + 12 * nu) * m * m) * area;  // Cowper
  return {.area = area,
          .shear_areas = {shear, shear},
          .moments = {I, I},
          .torsion_constant = 2 * I,
          .outline = octagon(diameter / 2),
          .fibres = ring_fibres(diameter, inner)};
}

BeamStiffness BeamData::stiffness(double young_modulus) const {
  const double E = young_modulus, G = shear_modulus;
  return {.force = {E * section.area, G * section.shear_areas[0], G * section.shear_areas[1]},
          .moment = {G * section.torsion_constant, E * section.moments[0], E * section.moments[1]}};
}

KeyTable cross_section_keys() {
  const auto length = [](const std::string& name, const std::string& sentence,
                         const std::vector<std::string>& shapes) {
    return key::number(name, "m", sentence).in(positive()).when("shape", shapes);
  };
  const std::vector<std::string> general = {"general"};
  return {"cross_section",
          "Cross-section of a beam. Axes 2 and 3 lie in it; in 2D axis 3 is normal to the plane.",
          {key::choice("shape", {"rectangle", "circle", "pipe", "general"},
                       "Shape, whose shear areas are those of Cowper (1966); `general`: all values "
                       "are given."),
           length("height", "Extent along axis 2.", {"rectangle"}),
           length("width", "Extent along axis 3.", {"rectangle"}),
           length("diameter", "Outer diameter.", {"circle", "pipe"}),
           length("wall", "Thickness of the wall.", {"pipe"}),
           key::number("area", "m^2", "Area.").in(positive()).when("shape", general),
           key::vector("shear_areas", "m^2", "Shear areas for forces along axes 2 and 3.")
               .in(positive())
               .wide(2, 2)
               .when("shape", general),
           key::vector("second_moments", "m^4", "Second moments of area about axes 2 and 3.")
               .in(positive())
               .wide(2, 2)
               .when("shape", general),
           key::number("torsion_constant", "m^4",
                       "Torsion constant: torsional stiffness over shear modulus.")
               .in(positive())
               .when("shape", general)}};
}

std::vector<Key> beam_keys() {
  const std::vector<std::string> beam = {"beam"};
  return {
      key::object("cross_section", cross_section_keys(), "Cross-section of the beams.")
          .when("law", beam),
      key::vector("orientation", "",
                  "Direction of axis 2 of the section, a vector of any length, not along the beam; "
                  "only its part normal to the beam counts. Needed unless the section is round.")
          .wide(3, 3)
          .or_none()
          .when("law", beam)
          .only("in 3D"),
      key::number(
          "spacing", "m",
          "Distance between beams normal to the plane; each of them carries this thickness. Forces "
          "and moments in tables are per metre of thickness; times this distance they are those of "
          "one beam.")
          .in(positive())
          .or_else(1)
          .when("law", beam)
          .only("in 2D")};
}

namespace {

CrossSection read_section(ConfigReader in, double nu, int dim) {
  const std::string shape = in.choice("shape");
  CrossSection section;
  if (shape == "rectangle") {
    section = rectangle_section(in.number("height"), in.number("width"), nu, dim);
  } else if (shape == "general") {
    const auto shear = in.vector("shear_areas", 2), moments = in.vector("second_moments", 2);
    section = {.area = in.number("area"),
               .shear_areas = {shear[0], shear[1]},
               .moments = {moments[0], moments[1]},
               .torsion_constant = in.number("torsion_constant")};
  } else {
    const double diameter = in.number("diameter");
    double inner = 0;
    if (shape == "pipe") {
      const double wall = in.number("wall");
      if (!(wall < 0.5 * diameter)) {
        in.fail("wall", fmt::format("found {}, allowed: less than half the diameter, {}", wall,
                                    0.5 * diameter));
      }
      inner = diameter - 2 * wall;
    }
    section = ring_section(diameter, inner, nu);
  }
  in.finish();
  return section;
}

}  // namespace

BeamData read_beam(ConfigReader& in, double young_modulus, int dim) {
  const double nu = in.number("poisson_ratio");
  BeamData beam{.section = read_section(in.object("cross_section"), nu, dim),
                .shear_modulus = young_modulus / (2 * (1 + nu))};
  if (dim == 2) {
    beam.section = beam.section.over(in.number("spacing"));
    return beam;
  }
  if (const auto direction = in.optional_vector("orientation")) {
    beam.orientation = Vector<3>((*direction)[0], (*direction)[1], (*direction)[2]);
    if (beam.orientation->isZero(0)) in.fail("orientation", "found length 0, allowed: > 0");
  } else if (!beam.section.is_round()) {
    in.fail("orientation",
            "found none, allowed: the direction of axis 2 of a section that is not "
            "round");
  }
  return beam;
}

}  // namespace gabion::fem
