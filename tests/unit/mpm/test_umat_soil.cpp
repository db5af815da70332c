// SPDX-License-Identifier: BSD-3-Clause
// Soil with a law from a shared library, in whole scenes.
#include <gtest/gtest.h>

#include <cmath>

#include "solver_program/ranked_state.hpp"
#include "tests/support/expect_error.hpp"
#include "tests/unit/mpm/mpm_scene.hpp"

namespace gabion::test::test_umat_soil {
namespace {

constexpr double lambda = 2e5, mu = 1e5, degree = 3.14159265358979323846 / 180;

Json native_soil() {
  const double E = mu * (3 * lambda + 2 * mu) / (lambda + mu), nu = lambda / (2 * (lambda + mu));
  Json soil = elastic_soil("mohr_coulomb", E, nu, 2000);
  soil["friction_angle"] = 30;
  soil["cohesion"] = 200;
  return soil;
}
Json library_soil() {
  return {{"law", "umat"},
          {"density", 2000},
          {"library", UMAT_MOHR_COULOMB},
          {"constants", {lambda, mu, 30 * degree, 0, 200}},
          {"initial_variables", {0, 0}}};
}

/// A column that collapses.
Json column(const Json& soil, const std::string& analysis) {
  Json json = {{"dimension", 2},
               {"gravity", {0, -9.81}},
               {"grid", box({0, 0}, {2, 1}, {16, 8}, "quad4")},
               {"walls", {wall("bottom", "fixed"), wall("left", "slip")}},
               {"bodies", {body("soil", box({0, 0}, {0.5, 0.75}, {4, 6}, "quad4"), 4, soil)}}};
  if (analysis == "explicit") {
    json["time_integration"] = {{"scheme", "explicit"}};
  } else {
    json["analysis"] = analysis;
    json["newton"] = exact_newton;
  }
  return json;
}

double difference(const mpm::MaterialPoints<2>& a, const mpm::MaterialPoints<2>& b) {
  double largest = 0;
  for (std::int32_t p = 0; p < a.size(); ++p) {
    largest = std::max(largest, (a.x[p] - b.x[p]).norm());
  }
  return largest;
}

void expect_native_motion(const std::string& analysis, const std::string& locking, double dt) {
  Json native = column(native_soil(), analysis), library = column(library_soil(), analysis);
  native["locking"] = library["locking"] = {{"method", locking}};
  const auto a = mpm_solver<2>(native), b = mpm_solver<2>(library);
  run_steps(*a, dt, 20);
  run_steps(*b, dt, 20);
  double moved = 0, strained = 0;
  for (std::int32_t p = 0; p < a->points().size(); ++p) {
    moved = std::max(moved, a->points().u[p].norm());
    strained = std::max(strained, a->points().history[p].plastic_strain);
  }
  EXPECT_GT(moved, 0.01);
  EXPECT_GT(strained, 1e-3);
  EXPECT_LT(difference(a->points(), b->points()), 1e-6 * moved) << analysis << ", " << locking;
}

TEST(UmatSoil, moves_as_soil_of_the_native_law) {
  expect_native_motion("dynamic", "none", 0.005);
  expect_native_motion("dynamic", "fbar", 0.005);
  expect_native_motion("explicit", "none", 0.005);  // several substeps
  expect_native_motion("explicit", "fbar", 0.005);
}

TEST(UmatSoil, a_saved_state_goes_on_with_the_same_bits) {
  for (const std::string analysis : {"dynamic", "explicit"}) {
    const Json json = column(library_soil(), analysis);
    const auto straight = mpm_solver<2>(json), first = mpm_solver<2>(json),
               second = mpm_solver<2>(json);
    run_steps(*straight, 0.005, 12);
    run_steps(*first, 0.005, 6);
    load_gathered(comm(), gather_state(comm(), first->save_state()), *second);
    run_steps(*second, 0.005, 6, 7);
    EXPECT_TRUE(same_bits<2>(second->points(), straight->points())) << analysis;
  }
}

/// Geostatic stress, and what remains of it at rest, are those of the native law.
TEST(UmatSoil, begins_with_the_stress_of_its_weight) {
  const auto at_rest = [](const Json& soil) {
    Json json = column(soil, "quasi_static");
    json["bodies"][0]["mesh"] = box({0, 0}, {2, 0.75}, {16, 6}, "quad4");
    json["walls"].push_back(wall("right", "slip"));
    json["bodies"][0]["initial_stress"] = {{"surface", 0.75}, {"k0", 0.5}};
    auto solver = mpm_solver<2>(json);
    run_steps(*solver, 0.1, 1);
    return solver;
  };
  const auto native = at_rest(native_soil()), library = at_rest(library_soil());
  double deepest = 0;
  for (std::int32_t p = 0; p < native->points().size(); ++p) {
    const Symmetric<2>& tau = native->points().tau[p];
    deepest = std::max(deepest, tau.norm());
    EXPECT_LT((library->points().tau[p] - tau).norm(), 1e-6 * 2000 * 9.81 * 0.75);
  }
  EXPECT_GT(deepest, 0.9 * 2000 * 9.81 * 0.75);
}

/// A column of soft elastic soil, whose points enter other cells.
Json soft_column(int fault, const Json& variables) {
  Json json = column({{"law", "umat"},
                      {"density", 20000},
                      {"library", UMAT_FAULTY},
                      {"constants", {fault}},
                      {"initial_variables", variables}},
                     "dynamic");
  json["bodies"][0]["velocity"] = {4, 0};
  json["walls"] = {wall("bottom", "slip")};
  json["locking"] = {{"method", "fbar"}};
  return json;
}

/// CELENT is the width of the narrowest band of shear, also where F-bar shares volumes.
TEST(UmatSoil, length_of_all_increments) {
  const auto solver = mpm_solver<2>(soft_column(7, {0}));
  for (int n = 1; n <= 20; ++n) {
    run_steps(*solver, 0.005, 1, n);
    for (const auto& variables : solver->points().variables) {
      EXPECT_EQ(variables[24], 0.125) << n;  // the first of STATEV
    }
  }
}

TEST(UmatSoil, a_law_that_refuses_to_share_volumes_is_named) {
  const auto solver = mpm_solver<2>(soft_column(8, Json::array()));
  expect_error<Error>([&] { run_steps(*solver, 0.005, 20); },
                      {"material point", " at (", "DTIME 0", "\"locking\""});
}

TEST(UmatSoil, a_missing_library_is_named) {
  Json soil = library_soil();
  soil["library"] = "laws/nothing.so";
  expect_error<ConfigError>([&] { mpm_solver<2>(column(soil, "dynamic")); },
                            {"laws/nothing.so, which is no file"});
}

}  // namespace
}  // namespace gabion::test::test_umat_soil
