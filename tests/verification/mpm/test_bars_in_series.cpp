// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/verification_row.hpp"
#include "tests/unit/mpm/mpm_scene.hpp"
#include "tests/verification/mpm/coupled_run.hpp"

namespace gabion::test {
namespace {

/// Soil from x = 0 to L1 between smooth walls, then a bar of finite elements up to L1 + L2 whose
/// far end moves by D towards the soil, while a traction q pulls at its wet face in the same
/// direction (so that the bar is loaded before the soil answers). Three springs in series:
///
///     F = (D + q L2 / E2) / (L1 / (M1 A) + L2 / (E2 A) + 1 / (eps A))
constexpr double L1 = 1, L2 = 0.5, A = 0.5, E1 = 1e6, nu1 = 0.25, E2 = 4e6, eps = 2e7;
constexpr double D = 1e-8, q = 8e-3, total = D + q * L2 / E2;

/// The soil is so light that the steps of 1 s are static: density L^2 / (M dt^2) = 1e-14.
Json soil(const std::string& type) {
  return {{"dimension", 2},
          {"grid", box({0, 0}, {L1 + 0.25, A}, {5, 2}, type)},
          {"basis", "linear"},
          {"walls", {wall("left", "fixed"), wall("bottom", "slip"), wall("top", "slip")}},
          {"bodies",
           {body("soil", box({0, 0}, {L1, A}, {4, 2}, type), type == "tri3" ? 3 : 4,
                 elastic_soil("linear_elastic", E1, nu1, 1e-8))}},
          {"newton", {{"residual_tolerance", 1e-12}, {"increment_tolerance", 1e-12}}},
          {"interfaces",
           {{{"name", "face"},
             {"surface", {{"polyline", {{L1, A}, {L1, 0}}}, {"spacing", A / 2}}},
             {"method", "boundary_points"},
             {"penalty", eps}}}}};
}

Json structure(double rate) {
  return {
      {"dimension", 2},
      {"mesh", box({L1, 0}, {L1 + L2, A}, {3, 2}, "quad4")},
      {"material", elastic_soil("linear_elastic", E2, 0, 1)},
      {"analysis", "static"},
      {"supports",
       {{{"group", "bottom"}, {"components", {"y"}}}, {{"group", "top"}, {"components", {"y"}}}}},
      {"prescribed", {{{"group", "right"}, {"component", "x"}, {"rate", rate}}}},
      {"tractions", {{{"group", "left"}, {"traction", {-q, 0}}}}},
      {"newton", {{"residual_tolerance", 1e-12}, {"increment_tolerance", 1e-12}}},
      {"interfaces", {{{"name", "face"}, {"groups", {"left"}}}}}};
}

struct Pressed {
  Vector<2> force = Vector<2>::Zero();  // on the structure
  double displacement = 0;              // mean of the face, towards +x
};

/// @param scale  largest displacement [m] and force [N], for the limits of convergence
Pressed press(const Json& soil, const Json& structure, int steps, const Vector<2>& scale) {
  const auto soil_solver = make_mpm(soil);
  const auto structure_solver = make_fem(structure);
  Witness soil_side(*soil_solver), structure_side(*structure_solver);
  CouplerSettings settings;
  settings.time = {double(steps), 1.0, 1.0 / 4};
  settings.output_interval = 100;
  settings.participants = {{"soil", true}, {"structure", false}};
  settings.interfaces = {{"face", "soil", "structure"}};
  settings.coupling.acceleration.method = "iqn_ils";
  settings.coupling.max_iterations = 60;
  settings.coupling.convergence.displacement = {1e-8 * scale[0], 1e-8, 1e-12 * scale[0], {}};
  settings.coupling.convergence.force = {scale[1], 1e-8, 1e-12, {}};
  settings.coupling.mapping.tolerance = 1e-9;
  run_coupled(settings, soil_side, structure_side);
  Pressed result;
  const auto& f = soil_side.answer.at("face");
  const auto& x = structure_side.answer.at("face");
  for (std::size_t k = 0; k < f.size(); k += 2) result.force += Vector<2>(f[k], f[k + 1]);
  for (std::size_t k = 0; k < x.size(); k += 2) result.displacement += 2 * x[k] / double(x.size());
  return result;
}

TEST(V20_BarsInSeries, force_is_that_of_three_springs) {
  const double M1 = E1 * (1 - nu1) / ((1 + nu1) * (1 - 2 * nu1));
  const double F = total / (L1 / (M1 * A) + L2 / (E2 * A) + 1 / (eps * A));
  for (const std::string type : {"quad4", "tri3"}) {
    for (const int steps : {1, 4}) {
      const Pressed pressed = press(soil(type), structure(-D / steps), steps, {D, 1e-3});
      verify({.id = "V20",
              .what = "force on bars in series, MPM " + type + " and FEM, " +
                      std::to_string(steps) + (steps == 1 ? " step" : " steps"),
              .exact = F,
              .computed = pressed.force[0],
              .bound = 1e-7,
              .unit = "N/m"});
      EXPECT_NEAR(pressed.force[1], 0, 1e-6 * F);
      EXPECT_NEAR(pressed.displacement, -total + F * L2 / (E2 * A), 1e-6 * total);
    }
  }
}

/// The bars with facets, in finite strain: Hencky's law, nu = 0. With the stretches s1 and s2 of
/// the bars and the depth d,
///
///     F / A = -E1 ln(s1) / s1 = q - E2 ln(s2) / s2 = (A' / A) c E1 (d / h)^2 ,
///     L1 (1 - s1) + L2 (1 - s2) + d = D
///
/// A' is the area that the points stand for, A that of the face.
namespace facets {

constexpr double h = 0.25, c = 10, path = 0.01, pull = 100;  // pull is q [Pa]

Json soft_bar() {
  Json json = soil("quad4");
  json["analysis"] = "quasi_static";
  json["bodies"][0]["material"] = elastic_soil("hencky_elastic", E1, 0, 1000);
  json["interfaces"] = {{{"name", "face"},
                         {"surface", {{"polyline", {{L1, A}, {L1, 0}}}, {"spacing", A / 2}}},
                         {"mode", "slip"}}};
  return json;
}

Json stiff_bar(double rate) {
  Json json = structure(rate);
  json["material"] = elastic_soil("hencky_elastic", E2, 0, 1);
  json["tractions"][0]["traction"] = {-pull, 0};
  return json;
}

/// Stretch of a bar under the pressure p.
double stretch(double p, double E) {
  double s = 1;
  for (int k = 0; k < 50; ++k) s = std::exp(-p * s / E);
  return s;
}

double depth(double p) {
  const double area_ratio = 0.5 / (1 - std::sqrt(1 / 3.0));
  return h * std::sqrt(p / (area_ratio * c * E1));
}

double force() {
  double low = 0, high = E1;
  while (high - low > 1e-14 * high) {
    const double p = 0.5 * (low + high);
    const double sum = L1 * (1 - stretch(p, E1)) + L2 * (1 - stretch(p - pull, E2)) + depth(p);
    (sum > path ? high : low) = p;
  }
  return low * A;
}

}  // namespace facets

TEST(V20_BarsInSeries, force_of_bars_that_touch_by_facets) {
  const double F = facets::force();
  for (const int steps : {1, 4}) {
    const Pressed pressed = press(facets::soft_bar(), facets::stiff_bar(-facets::path / steps),
                                  steps, {facets::path, F});
    verify({.id = "V20",
            .what = fmt::format("force on bars in series, MPM quad4 by facets and FEM, {} step{}",
                                steps, steps == 1 ? "" : "s"),
            .exact = F,
            .computed = pressed.force[0],
            .bound = steps == 1 ? 1e-6 : 1.65e-5,
            .unit = "N/m",
            .limitation = steps == 1 ? ""
                                     : "from the second step on forces see the volume of the "
                                       "undeformed cell, the square of the strain of 0.5 %"});
    EXPECT_NEAR(pressed.force[1], 0, 1e-9 * F);
    EXPECT_NEAR(pressed.displacement,
                -facets::path + L2 * (1 - facets::stretch(F / A - facets::pull, E2)),
                2e-5 * facets::path);
  }
}

}  // namespace
}  // namespace gabion::test
