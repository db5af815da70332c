// SPDX-License-Identifier: BSD-3-Clause
// Paths of element tests against closed forms.
#include <gtest/gtest.h>

#include <cmath>

#include "common/mechanics/tensor_functions.hpp"
#include "tests/support/expect_error.hpp"
#include "tests/unit/element_test/followed.hpp"

namespace gabion::testing::test_element_paths {
namespace {

double deviator(const ElementState& state) {
  const auto sigma = state.stress();
  return (sigma[0] + sigma[2]) / 2 - sigma[1];
}

Json compression(double strain, double confinement, const char* drainage = "drained") {
  return {{"name", "shear"},
          {"strain", {{"yy", strain}}},
          {"stress", {{"xx", confinement}, {"zz", confinement}}},
          {"drainage", drainage},
          {"increments", 40}};
}

TEST(ElementPaths, triaxial_peak_of_mohr_coulomb) {
  for (const double confinement : {2e4, 1e5, 4e5}) {
    const auto states =
        follow({{"material", sand()},
                {"stages", {consolidation(confinement), compression(0.1, confinement)}}});
    const double J = std::exp(states.back().log_J), sine = std::sin(33 * degree);
    const double k = (1 + sine) / (1 - sine);
    const double peak = (k - 1) * confinement + 2 * 5000 * std::sqrt(k) / J;  // cohesion by tau
    EXPECT_NEAR(deviator(states.back()), peak, 1e-10 * peak);
    EXPECT_NEAR(states.back().strain[0], states.back().strain[2], 1e-12);
  }
}

TEST(ElementPaths, triaxial_extension_of_mohr_coulomb) {
  Json cohesionless = sand();
  cohesionless["cohesion"] = 0;
  const auto states = follow(
      {{"material", cohesionless}, {"stages", {consolidation(1e5), compression(-0.1, 1e5)}}});
  const double sine = std::sin(33 * degree), k = (1 + sine) / (1 - sine);
  EXPECT_NEAR(deviator(states.back()), -1e5 * (1 - 1 / k), 1e-5);
}

TEST(ElementPaths, undrained_strength_of_tresca) {
  const auto states = follow(
      {{"material", clay()}, {"stages", {consolidation(2e5), compression(0.1, 2e5, "undrained")}}});
  const double J = std::exp(states.back().log_J);
  EXPECT_NEAR(deviator(states.back()), 2 * 4e4 / J, 1e-5);
  EXPECT_NEAR(states.back().log_J, states[5].log_J, 1e-14);
}

// Undrained strength of modified Cam-Clay: P at the critical state is P_0 (R / 2)^(1 - kappa /
// lambda), R = P_c / P_0, with the slopes for Kirchhoff pressures, whatever the pressure is for
// which the constants of the law are given.
TEST(ElementPaths, undrained_strength_of_clay_after_consolidation) {
  const double M = 1.1, lambda = 0.1, kappa = 0.02, a = 50, p = 1e5;
  const double power = 1 - kappa / (1 - kappa) * (1 - lambda) / lambda;
  std::vector<double> early;
  for (const double reference : {2.5e4, 1e5, 4e5}) {
    const Json soft = {{"law", "cam_clay"},
                       {"density", 1800},
                       {"poisson_ratio", 0.3},
                       {"compression_index", lambda},
                       {"swelling_index", kappa},
                       {"critical_state_ratio", M},
                       {"reference_pressure", reference},
                       {"attraction", a}};
    for (const double ocr : {1.0, 4.0}) {
      Json first = consolidation(p);
      first["ocr"] = ocr;
      const auto states =
          follow({{"material", soft}, {"stages", {first, compression(0.4, p, "undrained")}}});
      const double J = std::exp(states.back().log_J), P = a + J * p, P_c = a + ocr * J * p;
      const double strength = M * P * std::pow(P_c / P / 2, power) / J;
      EXPECT_NEAR(deviator(states.back()), strength, 1e-6 * strength) << reference << " " << ocr;
      if (ocr == 1) early.push_back(deviator(states[8]));
    }
  }
  EXPECT_NEAR(early[0], early[1], 0.01 * early[1]);  // J of the consolidation
  EXPECT_NEAR(early[2], early[1], 0.01 * early[1]);
}

TEST(ElementPaths, clay_remembers_its_stages_where_no_ratio_is_given) {
  const Json soft = {{"law", "cam_clay"},        {"density", 1800},
                     {"poisson_ratio", 0.3},     {"compression_index", 0.1},
                     {"swelling_index", 0.02},   {"critical_state_ratio", 1.1},
                     {"reference_pressure", 1e5}};
  Json unloading = consolidation(1e5);
  unloading["name"] = "unloading";
  Json anew = unloading;
  anew["ocr"] = 1;
  const Json shear = compression(0.4, 1e5, "undrained");
  const auto kept =
      follow({{"material", soft}, {"stages", {consolidation(4e5), unloading, shear}}});
  const auto reset = follow({{"material", soft}, {"stages", {consolidation(4e5), anew, shear}}});
  EXPECT_NEAR(deviator(kept.back()) / deviator(reset.back()), std::pow(4, 0.8), 0.01);
}

TEST(ElementPaths, oedometer_of_an_elastic_soil) {
  for (const double nu : {0.0, 0.2, 0.45}) {
    const auto states = follow(
        {{"material", elastic(nu)}, {"stages", {{{"name", "load"}, {"stress", {{"yy", 5e5}}}}}}});
    const auto sigma = states.back().stress();
    EXPECT_NEAR(sigma[1], -5e5, 1e-6);
    EXPECT_NEAR(sigma[0] / sigma[1], nu / (1 - nu), 1e-11);
    EXPECT_EQ(states.back().strain[0], 0);
  }
}

TEST(ElementPaths, mean_stress_stays_while_the_sample_is_sheared) {
  const auto states = follow({{"material", sand()},
                              {"stages",
                               {consolidation(1e5),
                                {{"name", "shear"},
                                 {"strain", {{"yy", 0.05}}},
                                 {"mean_stress", 1e5},
                                 {"moved_by", {"zz", "xx"}},
                                 {"increments", 20}}}}});
  const auto sigma = states.back().stress();
  EXPECT_NEAR(sigma.head<3>().mean(), -1e5, 1e-6);
  EXPECT_NEAR(sigma[0], sigma[2], 1e-6);
  EXPECT_GT(deviator(states.back()), 1e5);
}

// Skempton's B = 1 / (1 + n K / K_w) and A = 1/3 of an elastic skeleton, for small loads.
TEST(ElementPaths, pore_pressure_by_skempton) {
  const double K = 1e7 / (3 * (1 - 2 * 0.3)), load = 10;
  const Json water = {{"porosity", 0.4}, {"bulk_modulus", 2e8}, {"density", 1000}};
  const double B = 1 / (1 + 0.4 * K / 2e8);
  const Json settings = {
      {"material", elastic()},
      {"water", water},
      {"back_pressure", 5e4},
      {"stages",
       {{{"name", "squeeze"}, {"stress", all_around(5e4 + load)}, {"drainage", "undrained"}},
        {{"name", "shear"},
         {"stress", {{"yy", 5e4 + 2 * load}, {"xx", 5e4 + load}, {"zz", 5e4 + load}}},
         {"drainage", "undrained"}}}}};
  Json with_back = settings;  // begins with the total stress of the back pressure alone
  const auto states = follow(with_back);
  EXPECT_EQ(states.front().pore_pressure, 5e4);
  EXPECT_NEAR(states[100].pore_pressure - 5e4, B * load, 1e-5 * load);
  EXPECT_NEAR(states[200].pore_pressure - 5e4, B * (load + load / 3), 1e-5 * load);
}

TEST(ElementPaths, soil_that_keeps_its_volume_is_the_limit_of_stiff_water) {
  Json test = {{"material", sand()},
               {"stages", {consolidation(1e5), compression(0.05, 1e5, "undrained")}}};
  const auto kept = follow(test);
  EXPECT_NEAR(kept.back().log_J, kept[5].log_J, 1e-14);
  EXPECT_LT(kept.back().pore_pressure, 0);  // it would dilate
  EXPECT_NEAR(kept.back().stress()[0], -1e5, 1e-5);
  test["water"] = {{"porosity", 0.4}, {"bulk_modulus", 2e12}, {"cavitation_pressure", 1e9}};
  const auto stiff = follow(test);
  EXPECT_NEAR(stiff.back().pore_pressure, kept.back().pore_pressure,
              1e-4 * std::abs(kept.back().pore_pressure));
}

TEST(ElementPaths, pore_pressure_goes_back_when_it_drains) {
  Json drain = consolidation(2e5);
  drain["name"] = "drain";
  Json load = consolidation(2e5);
  load["drainage"] = "undrained";
  const auto states = follow({{"material", sand()}, {"stages", {consolidation(1e5), load, drain}}});
  EXPECT_NEAR(states[10].pore_pressure, 1e5, 1e-3);
  EXPECT_EQ(states[15].pore_pressure, 0);
  EXPECT_NEAR(states[15].effective_stress()[1], -2e5, 1e-6);
}

TEST(ElementPaths, softening_follows_its_table) {
  Json soil = clay();
  soil["softening"] = {{"table", {{0.01, 3e4}, {0.05, 1e4}, {0.1, 5e3}}}};
  const Json test = {{"material", soil},
                     {"band_width", 0.2},
                     {"stages", {consolidation(1e5), compression(0.3, 1e5)}}};
  const auto settings = read(test);
  const auto& curve = std::get<SofteningSoil<3>>(settings.material.law).surface().curve;
  const auto states = follow(test);
  for (std::size_t k = 6; k < states.size(); ++k) {
    if (states[k].region == YieldRegion::elastic) continue;
    const double c = curve.at(states[k].internal[1]).value.cohesion;
    EXPECT_NEAR(deviator(states[k]) * std::exp(states[k].log_J), 2 * c, 1e-8 * c);
    EXPECT_NEAR(states[k].internal[1], std::numbers::sqrt3 * 0.2 * states[k].internal[0], 1e-14);
  }
  EXPECT_NEAR(deviator(states.back()) * std::exp(states.back().log_J), 2 * 5e3, 1e-4);
}

Json steady_shear(const char* kind, double end, double duration) {
  Json stage = {{"name", "shear"}, {"increments", 200}, {"duration", duration}};
  stage[kind] = {{"xy", end}};
  return stage;
}

TEST(ElementPaths, mud_at_a_rate_of_shear) {
  for (const double n : {0.5, 1.0, 1.7}) {
    for (const double rate : {0.1, 10.0}) {
      const auto states = follow({{"material", mud(n)},
                                  {"rotation", "simple_shear"},
                                  {"stages", {steady_shear("strain", 0.5, 0.5 / rate)}}});
      const double expected = 100 + 50 * std::pow(rate, n);
      EXPECT_NEAR(states.back().stress()[3], expected, 1e-4 * expected) << n << " " << rate;
    }
  }
}

TEST(ElementPaths, mud_creeps_under_a_shear_stress) {
  const auto states =
      follow({{"material", mud()},
              {"rotation", "simple_shear"},
              {"stages", {steady_shear("stress", 150, 1e-6), steady_shear("stress", 150, 0.2)}}});
  const double rate = (150.0 - 100) / 50;
  EXPECT_NEAR(states.back().strain[3] - states[200].strain[3], 0.2 * rate, 2e-4 * 0.2);
}

TEST(ElementPaths, fluid_has_its_viscosity_and_no_strength) {
  Json rest = steady_shear("stress", 0, 1);
  const auto states = follow({{"material", oil()},
                              {"rotation", "simple_shear"},
                              {"stages", {steady_shear("strain", 0.5, 0.5 / 10.0), rest}}});
  EXPECT_NEAR(states[200].stress()[3], 10 * 20, 1e-4 * 200);
  EXPECT_NEAR(states.back().stress().norm(), 0, 1e-3);
  const double flow = 0.5 * (1 - 1.0 / 200) * 200 / 20;  // the stress falls in 200 increments
  EXPECT_NEAR(states.back().strain[3] - states[200].strain[3], flow, 1e-3 * flow);
}

TEST(ElementPaths, cycles_of_an_elastic_soil_close) {
  Json stages = {consolidation(1e5)};
  for (const double turn : {0.01, -0.01, 0.0}) {
    stages.push_back({{"name", "cycle"},
                      {"strain", {{"xy", turn}}},
                      {"stress", {{"yy", 1e5}}},
                      {"increments", 7}});
  }
  const auto states = follow({{"material", elastic()}, {"stages", stages}});
  EXPECT_NEAR((states.back().stress() - states[5].stress()).norm(), 0, 1e-6);
  EXPECT_NEAR((states.back().strain - states[5].strain).norm(), 0, 1e-13);
}

// The law in the plane, step by step as the soil's solver calls it, beside the one in space.
TEST(ElementPaths, strains_count_from_where_they_are_zero) {
  Json shear = compression(0.03, 1e5), whole = shear;
  shear["zero_strain"] = true;
  const auto states = follow({{"material", sand()}, {"stages", {consolidation(1e5), shear}}});
  const double before = states[5].strain[1], total = (1 + before) * (1 - 0.03) - 1;
  EXPECT_NEAR(states.back().strain[1], -0.03, 1e-15);
  EXPECT_EQ(states.back().zero_log_J, states[5].log_J);
  whole["strain"]["yy"] = -total;
  const auto same = follow({{"material", sand()}, {"stages", {consolidation(1e5), whole}}});
  EXPECT_NEAR(states.back().log_J, same.back().log_J, 1e-12);
  EXPECT_NEAR((states.back().stress() - same.back().stress()).norm(), 0, 1e-5);
}

TEST(ElementPaths, plane_strain_is_that_of_the_plane) {
  const Json soil = sand();
  const auto law = read_material<2>(ConfigReader(soil, "x", material_keys(material_laws))).law;
  const Json biaxial = {
      {"name", "shear"}, {"strain", {{"yy", 0.04}}}, {"stress", {{"xx", 1e5}}}, {"increments", 20}};
  const auto states =
      follow({{"material", soil},
              {"stages", {{{"name", "load"}, {"stress", {{"xx", 1e5}, {"yy", 1e5}}}}, biaxial}}});
  MaterialState<2> history;
  double log_J = 0;
  StressUpdate<2> out;
  for (std::size_t k = 1; k < states.size(); ++k) {
    const Matrix<3> step = states[k].F * states[k - 1].F.inverse();
    const Matrix<2> H = step.topLeftCorner<2, 2>() - Matrix<2>::Identity();
    ASSERT_TRUE(update<2>(law, H, history, out, nullptr));
    history = out.state;
    log_J += std::log(out.J);
  }
  const auto sigma = states.back().stress();
  for (int k = 0; k < 4; ++k) EXPECT_NEAR(out.tau[k] * std::exp(-log_J), sigma[k], 1e-5);
}

TEST(ElementPaths, stress_beyond_the_strength_is_refused_with_the_place) {
  std::string reason;
  const Json load = {
      {"name", "load"}, {"stress", {{"xx", 1e5}, {"yy", 1e6}, {"zz", 1e5}}}, {"increments", 100}};
  const auto states =
      follow({{"material", sand()}, {"stages", {consolidation(1e5), load}}}, &reason);
  test::expect_parts(reason, {"stage \"load\"", "stress yy 3578", "limit load"});
  EXPECT_GT(states.size(), 30u);
  EXPECT_LT(states.size(), 40u);
}

}  // namespace
}  // namespace gabion::testing::test_element_paths
