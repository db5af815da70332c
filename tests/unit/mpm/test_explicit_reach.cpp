// SPDX-License-Identifier: BSD-3-Clause
// Iterations of an explicit step that evaluate what the interfaces can reach, and those that solve
// all of the soil: the same bits.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/unit/mpm/mpm_scene.hpp"

namespace gabion::test::test_explicit_reach {
namespace {

Json sand(double cohesion = 0) {
  Json material = elastic_soil("mohr_coulomb", 1e5, 0.3, 1000);
  material["friction_angle"] = 30;
  if (cohesion > 0) material["cohesion"] = cohesion;
  return material;
}

struct Case {
  int dim = 2;
  std::string basis = "gimp", locking = "fbar";
  Json material = sand();
  double dt = 2e-3;
  bool rigid_floor = false;
  int num_steps = 5;
};

/// A long heap that runs against a plate at its left end.
Json heap(const Case& given) {
  const int dim = given.dim;
  const std::vector<int> cells = dim == 2 ? std::vector{48, 4} : std::vector{20, 2, 3};
  std::vector<double> low(dim, 0.0), high = {12.0, 0.5, 0.75}, from(dim, 0.0),
                                     to = {10.5, 0.5, 0.5};
  if (dim == 2) high = {12.0, 1.0}, to = {10.5, 0.5};
  from[0] = dim == 2 ? 0.475 : 0.43;  // the first contact spheres almost reach the plate
  if (given.rigid_floor) from[dim - 1] += 0.03, to[dim - 1] += 0.03;
  std::vector<double> velocity(dim, 0.0), gravity(dim, 0.0);
  velocity[0] = -2;
  gravity[dim - 1] = -9.81;
  const std::vector<int> laid = dim == 2 ? std::vector{40, 4} : std::vector{17, 2, 2};
  const std::string type = dim == 2 ? "quad4" : "hex8";
  std::vector<double> plate_low(dim, 0.0), plate_high = to;
  plate_low[0] = 0.25;
  plate_high[0] = 0.5;
  const std::vector<int> plate_cells = dim == 2 ? std::vector{1, 2} : std::vector{1, 2, 2};
  Json json = {
      {"dimension", dim},
      {"grid", box(low, high, cells, type)},
      {"basis", given.basis},
      {"locking", {{"method", given.locking}}},
      {"gravity", gravity},
      {"walls", {wall("bottom", "fixed")}},
      {"bodies",
       {body("soil", box(from, to, laid, type), dim == 2 ? 4 : 8, given.material, velocity)}},
      {"time_integration", {{"scheme", "explicit"}}},
      {"interfaces",
       {{{"name", "plate"},
         {"surface",
          {{"mesh", box(plate_low, plate_high, plate_cells, type)}, {"groups", {"right"}}}},
         {"friction", 0.4}}}}};
  if (given.rigid_floor) {
    json["walls"] = Json::array();
    Json floor = {{"polyline", {{12.0, 0.02}, {0.0, 0.02}}}, {"spacing", 0.25}};
    if (dim == 3) {
      floor = {{"mesh", box({0, 0, -0.25}, {12.0, 0.5, 0.02}, {20, 2, 1}, "hex8")},
               {"groups", {"top"}}};
    }
    json["rigid_walls"] = {{{"name", "floor"}, {"surface", floor}, {"friction", 0.3}}};
  }
  return json;
}

template <int dim>
std::unique_ptr<mpm::MpmSolver<dim>> solver_of(const Json& json, bool whole) {
  auto settings = mpm_settings<dim>(json);
  settings.whole_iterations = whole;
  return std::make_unique<mpm::MpmSolver<dim>>(comm(), std::move(settings), "");
}

/// The plate moved along x by about `push`, each vertex a little differently.
InterfaceValues plate_at(const Solver& solver, int dim, double push) {
  const InterfaceMesh mesh = solver.interfaces().front();
  std::vector<double> u(mesh.coordinates.size(), 0.0);
  for (std::size_t k = 0; k < u.size(); k += static_cast<std::size_t>(dim)) {
    u[k] = push * (1 + 0.1 * std::sin(static_cast<double>(k)));
  }
  return {{"plate", u}};
}

struct Shares {
  double points = 0;
  int whole = 0, solutions = 0;
};

/// Steps of several iterations; `places` of the plate in each, times the number of the step.
template <int dim>
Shares compare(const Case& given, const std::vector<double>& places) {
  const auto within = solver_of<dim>(heap(given), false), whole = solver_of<dim>(heap(given), true);
  for (int n = 1; n <= given.num_steps; ++n) {
    StepRequest request{n, 0, (n - 1) * given.dt, given.dt};
    for (std::size_t k = 0; k < places.size(); ++k) {
      InterfaceValues a, b;
      const InterfaceValues plate = plate_at(*within, dim, n * places[k]);
      request.iteration = static_cast<int>(k);
      const StepReport x = within->solve_step(request, plate, a);
      const StepReport y = whole->solve_step(request, plate, b);
      EXPECT_EQ(a, b) << "step " << n << " iteration " << k;
      EXPECT_EQ(x.details, y.details);
      if (n < given.num_steps || k + 1 < places.size()) continue;
      EXPECT_GT(x.details.at("closed_points"), 0);
      if (given.rigid_floor) {
        EXPECT_GT(x.details.at("floor.closed_points"), 0);
      }
    }
    within->accept_step(request, true);
    whole->accept_step(request, true);
    EXPECT_TRUE(same_bits(within->points(), whole->points())) << n;
    EXPECT_EQ(within->probes(), whole->probes()) << n;
  }
  const Json all = whole->summary()["explicit"], part = within->summary()["explicit"];
  EXPECT_EQ(all["repeated_point_share"], 1);
  EXPECT_EQ(all["substeps"], part["substeps"]);
  return {part["repeated_point_share"], part["repeated_whole"], part["repeated_solutions"]};
}

const std::vector<double> converging = {1e-3, 1.2e-3, 1.18e-3};

TEST(ExplicitReach, is_exact_in_one_substep) {
  for (const std::string basis : {"linear", "gimp", "bspline"}) {
    for (const std::string locking : {"none", "fbar"}) {
      SCOPED_TRACE(basis + " " + locking);
      const Shares found = compare<2>({.basis = basis, .locking = locking}, converging);
      EXPECT_LT(found.points, 0.3);
    }
  }
}

TEST(ExplicitReach, is_exact_in_several_substeps) {
  for (const std::string basis : {"linear", "gimp", "bspline"}) {
    SCOPED_TRACE(basis);
    const Shares found = compare<2>({.basis = basis, .dt = 0.04, .num_steps = 3}, converging);
    EXPECT_LT(found.points, 0.7);
  }
}

TEST(ExplicitReach, is_exact_in_space) {
  for (const std::string basis : {"linear", "gimp"}) {
    for (const double dt : {4e-3, 0.025}) {
      SCOPED_TRACE(basis);
      const Shares found =
          compare<3>({.dim = 3, .basis = basis, .dt = dt, .num_steps = 2}, converging);
      EXPECT_LT(found.points, 0.8);
    }
  }
}

TEST(ExplicitReach, is_exact_for_all_laws) {
  Json cone = sand(100), elastic = elastic_soil("neo_hookean", 1e5, 0.3, 1000), cut_off = sand(100),
       softening = sand(100);
  cone["law"] = "drucker_prager";
  cut_off["tension_cutoff"] = 20;
  softening["softening"] = {{"slip", 0.1}, {"residual_cohesion", 50}};
  for (const Json& material : {cone, elastic, cut_off, softening}) {
    SCOPED_TRACE(material.dump());
    const Shares found = compare<2>({.material = material, .dt = 0.02, .num_steps = 3}, converging);
    EXPECT_LT(found.points, 0.7);
  }
}

/// The force of other contacts changes with the soil that comes to them.
TEST(ExplicitReach, is_exact_with_soil_on_a_rigid_wall) {
  const Shares found =
      compare<2>({.dt = 0.01, .rigid_floor = true, .num_steps = 12}, {5e-4, 6e-4, 5.9e-4});
  EXPECT_LT(found.points, 0.7);
}

TEST(ExplicitReach, is_exact_in_space_with_soil_on_a_rigid_wall) {
  const Shares found =
      compare<3>({.dim = 3, .dt = 0.02, .rigid_floor = true, .num_steps = 6}, {5e-4, 6e-4, 5.9e-4});
  EXPECT_LT(found.points, 0.9);
}

/// A contact that the first iteration did not have is beyond its reach: all is solved again.
TEST(ExplicitReach, a_contact_of_a_later_iteration) {
  const Shares found = compare<2>({.num_steps = 3}, {-0.02, 1e-3, 1.1e-3});
  EXPECT_GT(found.whole, 0);
  EXPECT_LT(found.whole, found.solutions);
}

/// Where nearly all soil is in reach, solutions are whole.
TEST(ExplicitReach, most_of_the_soil) {
  const Shares found = compare<2>({.dt = 0.4, .num_steps = 1}, {0.01, 0.012});
  EXPECT_EQ(found.points, 1);
}

}  // namespace
}  // namespace gabion::test::test_explicit_reach
