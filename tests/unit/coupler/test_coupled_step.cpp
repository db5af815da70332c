// SPDX-License-Identifier: BSD-3-Clause
// One step of two springs, of which one pass, the fixed point and the failures are known.
#include <gtest/gtest.h>

#include <filesystem>

#include "coupler/step/coupled_step.hpp"
#include "tests/support/temporary_scene.hpp"
#include "tests/unit/coupler/mass_springs.hpp"

namespace gabion::test_coupled_step {
namespace {

using test::SoilSprings;
using test::StructureSprings;

constexpr double dt = 0.01;

CouplerSettings settings_for(Scheme scheme) {
  CouplerSettings s;
  s.participants = {{"soil", true}, {"structure", false}};
  s.interfaces = {{"wall", "soil", "structure"}};
  s.coupling.scheme = scheme;
  s.coupling.convergence.displacement.absolute = 1e-13;
  s.coupling.mapping.tolerance = 1e-9;
  return s;
}

/// The first step from rest; the soil's surface has three vertices, the structure's two.
struct OneStep {
  explicit OneStep(Scheme scheme) : settings(settings_for(scheme)) {
    soil.load = [](double) { return 5.0; };
  }
  Attempt solve() {
    const test::TemporaryScene folder("coupler.json", Json::object());
    PhaseTimes phases;
    RunRecord files(folder.path() + "/results", "coupler");
    Sides sides(settings, {{"soil", soil}, {"structure", structure}}, phases);
    CouplingRecord record(files, 2, {"wall"});
    record.start({});
    CoupledStep step(settings.coupling, sides, record, counts, phases);
    step.start_at_rest();
    sides.begin_step();
    Attempt done = step.solve({.step = 1, .iteration = 0, .time = 0, .dt = dt});
    if (!done.acceptable()) return done;
    EXPECT_EQ(done.u, sides.map().soil_displacement(done.x));
    EXPECT_EQ(done.f, sides.map().structure_force(done.f_soil));
    return done;
  }

  CouplerSettings settings;
  SoilSprings soil{3, 2, 10};
  StructureSprings structure{2, 1, 100};
  CouplingCounts counts;
};

TEST(CoupledStep, ends_where_both_sides_agree) {
  const double slope = NewmarkBossak().inertia_slope(dt);
  for (const Scheme scheme : {Scheme::serial_implicit, Scheme::parallel_implicit}) {
    OneStep one(scheme);
    one.soil.scatter = one.structure.scatter = 0;
    const Attempt done = one.solve();
    EXPECT_EQ(status(done), "converged") << name(scheme);
    EXPECT_EQ(done.skipped, Skipped::nothing);
    EXPECT_LE((done.x_tilde - done.x).cwiseAbs().maxCoeff(), 2e-13);
    // From rest each mass m and spring k push back with (m slope + k) u.
    const double hard_soil = 2 * slope + 10, hard_structure = slope + 100;
    for (int i = 0; i < 6; ++i) {
      EXPECT_NEAR(done.f_soil(i), (i % 2 == 0 ? 5 : 2.5) - hard_soil * done.u(i), 1e-9);
    }
    for (int i = 0; i < 4; ++i) {
      EXPECT_NEAR(done.x_tilde(i), done.f_given(i) / hard_structure, 1e-12);
    }
    EXPECT_EQ(one.counts.total, done.iterations());
    EXPECT_EQ(done.soil_newton, 2 * one.soil.solves);
    EXPECT_EQ(done.structure_newton, 2 * one.structure.solves);
  }
}

TEST(CoupledStep, the_explicit_scheme_is_one_pass_from_the_prediction) {
  OneStep one(Scheme::explicit_);
  const Attempt done = one.solve();
  EXPECT_EQ(status(done), "explicit");
  EXPECT_EQ(done.iterations(), 1);
  EXPECT_TRUE(done.x.isZero(0));
  EXPECT_EQ(done.f_soil(0), 5);
  EXPECT_GT(done.x_tilde(0), 0);
  EXPECT_EQ(one.soil.solves, 1);
}

TEST(CoupledStep, without_contact_x_is_what_the_structures_answer) {
  for (const Scheme scheme :
       {Scheme::serial_implicit, Scheme::parallel_implicit, Scheme::explicit_}) {
    OneStep one(scheme);
    one.soil.load = [](double) { return 0.0; };
    const Attempt done = one.solve();
    EXPECT_EQ(status(done), "inactive") << name(scheme);
    EXPECT_EQ(done.skipped,
              Skipped::acceleration);  // nobody knows yet that the structure is at rest
    EXPECT_EQ(done.x, done.x_tilde);
    EXPECT_EQ(done.row.state.displacement_residual, 0);
    EXPECT_EQ(done.iterations(), 1);
  }
}

TEST(CoupledStep, a_failure_says_whether_a_solver_is_the_reason) {
  OneStep of_solver(Scheme::serial_implicit);
  of_solver.structure.on_solve = [](const StepRequest& request) {
    if (request.iteration == 1) throw ConvergenceError("wall is gone");
  };
  const Attempt failed = of_solver.solve();
  EXPECT_EQ(failed.reason, "wall is gone");
  EXPECT_EQ(failed.outcome, Outcome::unsolved);
  EXPECT_EQ(failed.request.step, 1);

  OneStep at_limit(Scheme::serial_implicit);
  at_limit.settings.coupling.max_iterations = 2;
  const Attempt limited = at_limit.solve();
  EXPECT_EQ(limited.reason.find("coupling limit_reached after 2 iterations: "), 0u)
      << limited.reason;
  EXPECT_EQ(limited.outcome, Outcome::failed);
  EXPECT_EQ(status(limited), "limit_reached");
}

}  // namespace
}  // namespace gabion::test_coupled_step
