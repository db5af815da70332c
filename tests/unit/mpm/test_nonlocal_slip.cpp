// SPDX-License-Identifier: BSD-3-Clause
// Softening by a mean over the surroundings of a point.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "mpm_solver/stress/nonlocal_slip.hpp"
#include "solver_program/ranked_state.hpp"
#include "tests/support/expect_error.hpp"
#include "tests/unit/mpm/mpm_scene.hpp"
#include "tests/unit/mpm/soil_patch.hpp"

namespace gabion::test::test_nonlocal_slip {
namespace {

/// kbar of a point from its slip.
double mean_of(const mpm::SofteningAverage& average, const InternalState& internal) {
  const double x = internal[1] / (std::numbers::sqrt3 * average.slip_width());
  return (x - (1 - average.weight) * internal[0]) / average.weight;
}

/// Averages of softening strains on all ranks alone.
template <int dim>
struct AveragedPatch {
  SoilPatch<dim> soil;
  mpm::SofteningAverage average;

  AveragedPatch(CellType type, int cells, double length) : soil(type, cells), average{length, 2} {
    soil.fill(type == CellType::quad4 ? 4 : type == CellType::hex8 ? 8 : 1);
    mpm::add_internal(soil.points);
    for (double& J : soil.points.J) J = 1 + 0.2 * soil.random();
    soil.to_grid();
  }
  void follow() {
    mpm::set_nonlocal_slip<dim>({&average, 1}, soil.weights, soil.nodes, soil.points);
  }
  double mean(std::int32_t p) const { return mean_of(average, soil.points.internal[p]); }
};

template <int dim>
void check_means(CellType type) {
  AveragedPatch<dim> patch(type, 4, 0.4);
  auto& points = patch.soil.points;
  for (auto& internal : points.internal) internal[0] = 0.3;
  patch.follow();
  for (std::int32_t p = 0; p < points.size(); ++p) EXPECT_NEAR(patch.mean(p), 0.3, 1e-9);
  double integral = 0, of_means = 0, spread = 0;
  for (auto& internal : points.internal) internal[0] = std::abs(patch.soil.random());
  patch.follow();
  for (std::int32_t p = 0; p < points.size(); ++p) {
    const double V = points.V0[p] * points.J[p];
    integral += V * points.internal[p][0];
    of_means += V * patch.mean(p);
    spread = std::max(spread, std::abs(patch.mean(p) - 0.5));
  }
  EXPECT_NEAR(of_means, integral, 1e-9 * integral);
  EXPECT_LT(spread, 0.25);  // of numbers between 0 and 1
}

TEST(NonlocalSlip, keeps_even_strains_and_the_integral) {
  check_means<2>(CellType::quad4);
  check_means<2>(CellType::tri3);
  check_means<3>(CellType::hex8);
  check_means<3>(CellType::tet4);
}

/// Around a plane of strain the mean falls as exp(-y / l), to second order in the cells.
TEST(NonlocalSlip, falls_off_over_the_length) {
  double errors[2];
  for (int k = 0; k < 2; ++k) {
    const int cells = 20 << k;
    AveragedPatch<2> patch(CellType::quad4, cells, 0.1);
    auto& points = patch.soil.points;
    for (double& J : points.J) J = 1;
    for (std::int32_t p = 0; p < points.size(); ++p) points.internal[p][0] = points.x[p][1] < 0.2;
    patch.follow();
    errors[k] = 0;
    for (std::int32_t p = 0; p < points.size(); ++p) {
      // of the strip 0 < y < 0.2 with no flux at y = 0 and y = 1
      const double l = 0.1, y = points.x[p][1], a = 0.2, s = std::sinh(1 / l);
      const double exact = y < a ? 1 - std::sinh((1 - a) / l) / s * std::cosh(y / l)
                                 : std::sinh(a / l) / s * std::cosh((1 - y) / l);
      errors[k] = std::max(errors[k], std::abs(patch.mean(p) - exact));
    }
  }
  EXPECT_LT(errors[1], 0.01);
  EXPECT_GT(std::log2(errors[0] / errors[1]), 1.7);
}

/// The strains of two bodies in the same cells do not mix.
TEST(NonlocalSlip, stays_within_its_body) {
  AveragedPatch<2> patch(CellType::quad4, 4, 0.4);
  auto& points = patch.soil.points;
  const std::int32_t half = points.size() / 2;
  points.body_starts = {0, half, points.size()};
  patch.soil.to_grid();
  for (std::int32_t p = 0; p < points.size(); ++p) points.internal[p][0] = p < half ? 1 : 0;
  const mpm::SofteningAverage both[] = {patch.average, patch.average};
  mpm::set_nonlocal_slip<2>(both, patch.soil.weights, patch.soil.nodes, points);
  for (std::int32_t p = 0; p < points.size(); ++p) {
    EXPECT_NEAR(patch.mean(p), p < half ? 1 : 0, 1e-9);
  }
}

constexpr double speed = 0.05, peak = 1e4, residual = 3e3, slip = 0.02, l = 0.1;

/// Clay between two rough plates, sheared across a layer of 0.5 m with cells of 1 / 16 m.
template <int dim>
Json sheared_clay(const std::string& locking = "none") {
  Json clay = elastic_soil("tresca", 5e6, 0.45, 2000);
  clay["cohesion"] = peak;
  clay["softening"] = {{"slip", slip}, {"residual_cohesion", residual}};
  Json top = wall("top", "fixed");
  std::vector<double> low(dim, 0.0), high(dim, 0.5), grid_high(dim, 0.5), velocity(dim, 0.0);
  std::vector<int> cells(dim, 8), grid_cells(dim, 8);
  grid_high[0] = 0.75;
  grid_cells[0] = 12;
  if (dim == 3) {
    high[1] = grid_high[1] = 1.0 / 16;
    cells[1] = grid_cells[1] = 1;
  }
  velocity[0] = speed;
  top["motion"] = {{"velocity", velocity}};
  Json walls = {wall("bottom", "fixed"), top};
  if (dim == 3) {
    walls.push_back(wall("front", "slip"));
    walls.push_back(wall("back", "slip"));
  }
  const std::string type = dim == 2 ? "quad4" : "hex8";
  Json soil = body("soil", box(low, high, cells, type), dim == 2 ? 4 : 8, clay);
  soil["softening_average"] = {{"length", l}};
  return {{"dimension", dim},
          {"analysis", "quasi_static"},
          {"grid", box(low, grid_high, grid_cells, type)},
          {"walls", walls},
          {"locking", {{"method", locking}}},
          {"bodies", {soil}}};
}

template <int dim>
double most_slip(const mpm::MpmSolver<dim>& solver) {
  double most = 0;
  for (const auto& internal : solver.points().internal) most = std::max(most, internal[1]);
  return most;
}

template <int dim>
void check_restart(const Json& json, double dt, int steps) {
  const auto straight = mpm_solver<dim>(json), first = mpm_solver<dim>(json),
             second = mpm_solver<dim>(json);
  run_steps(*straight, dt, 2 * steps);
  run_steps(*first, dt, steps);
  load_gathered(comm(), gather_state(comm(), first->save_state()), *second);
  run_steps(*second, dt, steps, steps + 1);
  EXPECT_TRUE(same_bits<dim>(second->points(), straight->points()));
  EXPECT_EQ(second->probes(), straight->probes());
  EXPECT_GT(most_slip(*straight), 0.02 * slip);
}

Json with_cg(Json json) {
  json["linear_solver"] = {{"method", "gmres"}};
  return json;
}

TEST(NonlocalSlip, restart) {
  check_restart<2>(with_cg(sheared_clay<2>()), 0.02, 6);
  check_restart<2>(with_cg(sheared_clay<2>("fbar")), 0.02, 6);
  check_restart<3>(with_cg(sheared_clay<3>()), 0.03, 3);
}

Json explicit_clay() {
  Json json = sheared_clay<2>();
  json.erase("analysis");
  json["time_integration"] = {{"scheme", "explicit"}};
  return json;
}

TEST(NonlocalSlip, explicit_steps) {
  check_restart<2>(explicit_clay(), 0.02, 6);
  const auto solver = mpm_solver<2>(explicit_clay());
  double largest = 0, last = 0;
  for (int n = 1; n <= 60; ++n) {
    run_steps(*solver, 0.01, 1, n);
    last = std::abs(probe(*solver, "wall.top.fx")) / 0.5;
    largest = std::max(largest, last);
  }
  EXPECT_GT(largest, 0.8 * peak);
  EXPECT_LT(last, 0.75 * peak);
}

TEST(NonlocalSlip, number_of_ranks_does_not_change_the_result) {
  Json json = sheared_clay<2>("fbar");
  json["newton"] = exact_newton;
  json["linear_solver"] = {{"method", "mumps"}};
  const auto shared = mpm_solver<2>(json), alone = mpm_solver<2>(json, MPI_COMM_SELF);
  run_steps(*shared, 0.02, 10);
  run_steps(*alone, 0.02, 10);
  EXPECT_GT(most_slip(*alone), 0.02 * slip);
  const auto& points = shared->points();
  for (std::int32_t p = 0; p < points.size(); ++p) {
    const std::int32_t q = mpm::find_point(alone->points(), points.id[p]);
    EXPECT_LT((points.internal[p] - alone->points().internal[q]).norm(), 1e-8);
    EXPECT_LT((points.tau[p] - alone->points().tau[q]).norm(), 1e-4 * peak);
  }
}

TEST(NonlocalSlip, settings_that_cannot_be_are_refused) {
  const auto refused = [](const auto& change, const std::vector<std::string_view>& words) {
    Json json = sheared_clay<2>();
    change(json["bodies"][0]);
    expect_error<ConfigError>([&] { mpm_solver<2>(json); }, words);
  };
  refused([](Json& soil) { soil["softening_average"]["length"] = 0.09; },
          {"/bodies/0/softening_average/length", "0.09", "at least 0.09375"});
  refused([](Json& soil) { soil["softening_average"]["weight"] = 1; }, {"weight", "above 1"});
  refused([](Json& soil) { soil["material"].erase("softening"); },
          {"/bodies/0/softening_average", "does not soften"});
  refused(
      [](Json& soil) {
        soil["material"]["softening"] = {{"strain", 0.1}, {"residual_cohesion", residual}};
      },
      {"/bodies/0/softening_average", "strain"});
  refused([](Json& soil) { soil["material"]["softening"]["residual_cohesion"] = 2 * peak; },
          {"/bodies/0/material/softening", "rises"});
}

}  // namespace
}  // namespace gabion::test::test_nonlocal_slip
