// SPDX-License-Identifier: BSD-3-Clause
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

/// So light that the steps of 1 s are static: density L^2 / (M dt^2) = 1e-14.
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

Pressed press(const std::string& type, int steps, const std::string& acceleration) {
  const auto soil_solver = make_mpm(soil(type));
  const auto structure_solver = make_fem(structure(-D / steps));
  Witness soil_side(*soil_solver), structure_side(*structure_solver);
  CouplerSettings settings;
  settings.time = {double(steps), 1.0, 1.0 / 4};
  settings.output_interval = 100;
  settings.participants = {{"soil", true}, {"structure", false}};
  settings.interfaces = {{"face", "soil", "structure"}};
  settings.coupling.acceleration.method = acceleration;
  settings.coupling.max_iterations = 60;
  settings.coupling.convergence.displacement = {1e-8 * D, 1e-8, 1e-12 * D, {}};
  settings.coupling.convergence.force = {1e-3, 1e-8, 1e-12, {}};
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
      const Pressed pressed = press(type, steps, "iqn_ils");
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

}  // namespace
}  // namespace gabion::test
