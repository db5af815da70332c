// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "tests/support/convergence_rate.hpp"
#include "tests/unit/fem/fem_scene.hpp"

namespace gabion::test::test_step_mean_forces {
namespace {

const Json trapezoid = {{"scheme", "newmark"}};
const Json bossak = {{"scheme", "bossak"}, {"alpha", -0.2}};
constexpr double m = 0.5;  // [kg/m] of the right side of the cell

/// A mass on a spring: one cell of 1 m x 1 m, lumped mass, smooth sides, its right side moves and
/// is the interface.
Json one_mass(double stiffness, const Json& scheme) {
  return {{"dimension", 2},
          {"mesh", box_2d({1, 1}, {1, 1})},
          {"material", elastic("linear_elastic", stiffness, 0, 2 * m)},
          {"mass", "lumped"},
          {"time_integration", scheme},
          {"newton", {{"residual_tolerance", 1e-10}}},
          {"supports",
           {{{"group", "left"}},
            {{"group", "bottom"}, {"components", {"y"}}},
            {{"group", "top"}, {"components", {"y"}}}}},
          {"interfaces", {{{"name", "wall"}, {"groups", {"right"}}}}},
          {"probes", {{{"name", "A"}, {"point", {1, 0}}}}}};
}

/// The mass, with a force that may depend on where it is at the end of the step.
class OneMass {
 public:
  OneMass(double stiffness, const Json& scheme, ForceKind kind)
      : solver_(fem_solver<2>(one_mass(stiffness, scheme))) {
    solver_->set_force_kinds({{"wall", kind}});
  }

  void set_velocity(double v) {
    std::vector<double> u(8, 0.0), velocity(8, 0.0);
    for (int i = 0; i < 4; ++i) velocity[2 * i] = solver_->mesh().nodes[i][0] * v;
    solver_->set_motion(u, velocity);
  }
  double u() const { return probe(*solver_, "A.ux"); }
  double momentum() const { return probe(*solver_, "momentum_x"); }
  double energy() const {
    return probe(*solver_, "kinetic_energy") + probe(*solver_, "elastic_energy");
  }
  double work() const { return probe(*solver_, "external_work"); }

  double solve(double dt, double force) {
    InterfaceValues sent;
    solver_->solve_step(request(dt), {{"wall", {force / 2, 0, force / 2, 0}}}, sent);
    return sent.at("wall")[0];
  }
  void accept(double dt) {
    solver_->accept_step(request(dt), true);
    ++step_;
    time_ += dt;
  }
  /// @param force_at  of the displacement without force and of its derivative by the force
  void step(double dt, const std::function<double(double, double)>& force_at) {
    const double free = solve(dt, 0), slope = solve(dt, 1) - free;
    solve(dt, force_at(free, slope));
    accept(dt);
  }

 private:
  StepRequest request(double dt) const { return {step_, 0, time_, dt}; }

  std::unique_ptr<fem::FemSolver<2>> solver_;
  int step_ = 1;
  double time_ = 0;
};

/// A wall at u = gap that pushes back with the penalty k.
struct Wall {
  double k = 1, gap = 0;

  double energy(double u) const { return 0.5 * k * std::pow(std::max(u - gap, 0.0), 2); }
  /// Force that the end of the step balances, u = free + slope F.
  double at_end(double free, double slope) const {
    return -k * std::max(free - gap, 0.0) / (1 + k * slope);
  }
  /// Force whose work is the change of energy(): -(W' - W) / (u' - u), by bisection of the
  /// displacement u' = free + slope F, which the force only makes smaller.
  double discrete(double u, double free, double slope) const {
    const auto force = [&](double end) {
      const double p = std::max(u - gap, 0.0), q = std::max(end - gap, 0.0);
      if ((u > gap) == (end > gap)) return -0.5 * k * (p + q);
      return -0.5 * k * (q * q - p * p) / (end - u);
    };
    double low = free - slope * 0.5 * k * (std::max(u - gap, 0.0) + std::max(free - gap, 0.0)),
           high = free;
    for (int i = 0; i < 200; ++i) {
      const double middle = 0.5 * (low + high);
      (free + slope * force(middle) > middle ? low : high) = middle;
    }
    return force(0.5 * (low + high));
  }
};

enum class Law { at_end, discrete };

struct Impact {
  double k_dt2_by_m = 1, phase = 0;  // of the impact within a step
  Law law = Law::at_end;
};

/// The changes of the energy of mass, spring and wall in 40 steps with several impacts, by the
/// energy at the start: the largest growth and change in a step, and the largest energy.
struct EnergyChange {
  double growth = 0, change = 0, largest = 0;
};

EnergyChange bounce(const Impact& impact, ForceKind kind, const Json& scheme = trapezoid) {
  const double dt = 0.1, stiffness = 2, v0 = 1e-3;
  const Wall wall{.k = impact.k_dt2_by_m * m / (dt * dt), .gap = (2 + impact.phase) * dt * v0};
  OneMass mass(stiffness, scheme, kind);
  mass.set_velocity(v0);
  const double start = mass.energy();
  EnergyChange result;
  double before = start + wall.energy(mass.u());
  bool touched = false;
  for (int n = 0; n < 40; ++n) {
    const double u = mass.u();
    mass.step(dt, [&](double free, double slope) {
      return impact.law == Law::at_end ? wall.at_end(free, slope) : wall.discrete(u, free, slope);
    });
    const double after = mass.energy() + wall.energy(mass.u());
    result.growth = std::max(result.growth, (after - before) / start);
    result.change = std::max(result.change, std::abs(after - before) / start);
    result.largest = std::max(result.largest, after / start);
    touched = touched || mass.u() > wall.gap;
    before = after;
  }
  EXPECT_TRUE(touched);
  return result;
}

std::vector<Impact> impacts(Law law) {
  std::vector<Impact> all;
  for (const double k : {0.01, 1.0, 100.0, 1e4}) {
    for (int i = 0; i < 8; ++i) all.push_back({k, i / 8.0, law});
  }
  return all;
}

TEST(StepMeanForces, impacts_on_a_penalty_wall_make_no_energy) {
  double as_mean = 0, as_end = 0;
  for (const Impact& impact : impacts(Law::at_end)) {
    as_mean = std::max(as_mean, bounce(impact, ForceKind::step_mean).growth);
    as_end = std::max(as_end, bounce(impact, ForceKind::end_of_step).growth);
  }
  EXPECT_LT(as_mean, 1e-10);
  EXPECT_GT(as_end, 0.1);  // the same forces as those of the end of the step
}

/// Averaged inertia keeps no energy of single steps, but none is made over an impact.
TEST(StepMeanForces, impacts_with_averaged_inertia_stay_below_the_energy_at_the_start) {
  for (const Impact& impact : impacts(Law::at_end)) {
    EXPECT_LT(bounce(impact, ForceKind::step_mean, bossak).largest, 1)
        << impact.k_dt2_by_m << " " << impact.phase;
  }
}

TEST(StepMeanForces, forces_with_a_discrete_potential_keep_the_energy) {
  double change = 0;
  for (const Impact& impact : impacts(Law::discrete)) {
    change = std::max(change, bounce(impact, ForceKind::step_mean).change);
  }
  EXPECT_LT(change, 1e-10);
}

TEST(StepMeanForces, impulse_is_dt_times_the_force) {
  for (const Json& scheme : {trapezoid, bossak}) {
    OneMass mass(1e-12, scheme, ForceKind::step_mean);
    mass.set_velocity(1);
    double momentum = mass.momentum();
    for (int n = 0; n < 20; ++n) {
      const double dt = 0.1 / (1 + n % 3), force = std::sin(3.0 * n) + (n > 10 ? 2 : 0);
      mass.solve(dt, force);
      mass.accept(dt);
      momentum += dt * force;
      EXPECT_NEAR(mass.momentum(), momentum, 1e-11) << n;
    }
  }
}

/// After an impact in a long step a stiff structure moves so fast that its velocity would turn
/// cells inside out within the next step; the answer is near where it stands.
TEST(StepMeanForces, a_velocity_that_cannot_go_on_for_a_step_is_no_guess) {
  const double k = 1e6, dt = 0.05, v = -30;
  Json scene = one_mass(k, trapezoid);
  scene["material"] = elastic("neo_hookean", k, 0, 2 * m);
  const auto solver = fem_solver<2>(scene);
  std::vector<double> u(8, 0.0), velocity(8, 0.0);
  for (int i = 0; i < 4; ++i) velocity[2 * i] = solver->mesh().nodes[i][0] * v;
  solver->set_motion(u, velocity);
  ASSERT_LT(1 + dt * v, 0);
  InterfaceValues sent;
  solver->solve_step({1, 0, 0, dt}, {{"wall", {0, 0, 0, 0}}}, sent);
  // (4 m / dt^2 + k) u = 4 m v / dt, and some more for finite strain
  const double linear = 4 * m * v / dt / (4 * m / (dt * dt) + k);
  EXPECT_NEAR(sent.at("wall")[0], linear, 0.02 * std::abs(linear));
}

/// m u'' + k u = f sin(W t) from rest: u = f / (k - m W^2) (sin W t - W/w sin w t).
double error_at_end(const Json& scheme, int steps) {
  const double k = 2, f = 1, W = 3, end = 2, dt = end / steps, w = std::sqrt(k / m);
  OneMass mass(k, scheme, ForceKind::step_mean);
  for (int n = 0; n < steps; ++n) {
    mass.solve(dt, f * (std::cos(W * n * dt) - std::cos(W * (n + 1) * dt)) / (W * dt));
    mass.accept(dt);
  }
  const double factor = f / (k - m * W * W);
  const double u = factor * (std::sin(W * end) - W / w * std::sin(w * end));
  const double v = factor * W * (std::cos(W * end) - std::cos(w * end));
  return std::hypot(mass.u() - u, mass.momentum() / m - v);
}

TEST(StepMeanForces, mean_of_a_smooth_load_is_of_second_order) {
  for (const Json& scheme : {trapezoid, bossak}) {
    std::vector<double> sizes, errors;
    for (const int steps : {40, 80, 160}) {
      sizes.push_back(1.0 / steps);
      errors.push_back(error_at_end(scheme, steps));
    }
    EXPECT_GT(lowest_rate(sizes, errors), 1.9) << scheme;
    EXPECT_LT(lowest_rate(sizes, errors), 2.2) << scheme;
  }
}

/// Consistent mass, supports and two kinds of forces at once: the energy is the work of all.
template <int dim>
void check_work() {
  Json json = {
      {"dimension", dim},
      {"mesh", dim == 2 ? box_2d({4, 1}, {8, 2}) : box_3d({4, 1, 1}, {4, 1, 1})},
      {"material", elastic("linear_elastic", 50, 0.3, 2)},
      {"time_integration", trapezoid},
      {"newton", {{"residual_tolerance", 1e-10}}},
      {"supports", {{{"group", "left"}}}},
      {"interfaces",
       {{{"name", "end"}, {"groups", {"right"}}}, {{"name", "roof"}, {"groups", {"top"}}}}}};
  const auto solver = fem_solver<dim>(json);
  solver->set_force_kinds({{"roof", ForceKind::step_mean}});
  double error = 0, largest = 0;
  for (int n = 1; n <= 30; ++n) {
    InterfaceValues forces, sent;
    for (const InterfaceMesh& mesh : solver->interfaces()) {
      for (std::size_t i = 0; i < mesh.coordinates.size(); ++i) {
        forces[mesh.name].push_back(0.01 * std::sin(1.3 * double(i) + 2.1 * n));
      }
    }
    const StepRequest request{n, 0, (n - 1) * 0.3, 0.3};
    solver->solve_step(request, forces, sent);
    solver->accept_step(request, true);
    const double work = probe(*solver, "external_work");
    const double energy = probe(*solver, "kinetic_energy") + probe(*solver, "elastic_energy");
    error = std::max(error, std::abs(energy - work));
    largest = std::max(largest, energy);
  }
  EXPECT_GT(largest, 1e-6);
  EXPECT_LT(error, 1e-11 * largest);
}

TEST(StepMeanForces, their_work_is_the_energy_that_is_there) {
  check_work<2>();
  check_work<3>();
}

/// A force that stays holds a static structure as any other does; its work is F . du.
TEST(StepMeanForces, static_structures_take_them_as_they_are) {
  Json json = one_mass(8, trapezoid);
  json["analysis"] = "static";
  json.erase("time_integration");
  json.erase("mass");
  const auto solver = fem_solver<2>(json);
  solver->set_force_kinds({{"wall", ForceKind::step_mean}});
  for (int n = 1; n <= 3; ++n) {
    const StepRequest request{n, 0, double(n - 1), 1};
    InterfaceValues sent;
    solver->solve_step(request, {{"wall", {1.0 * n, 0, 1.0 * n, 0}}}, sent);
    solver->accept_step(request, true);
    EXPECT_NEAR(sent.at("wall")[0], 2.0 * n / 8, 1e-12);
  }
  EXPECT_NEAR(probe(*solver, "external_work"), (2 + 4 + 6) * 0.25, 1e-12);
}

}  // namespace
}  // namespace gabion::test::test_step_mean_forces
