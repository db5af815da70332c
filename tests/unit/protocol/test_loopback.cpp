// SPDX-License-Identifier: BSD-3-Clause
// Whole runs over a loopback socket, with solvers in threads of the test.
#include <gtest/gtest.h>

#include <cmath>
#include <thread>

#include "dummy_solver.hpp"

namespace gabion::test::test_loopback {
namespace {

struct Pair {
  DummySolver soil{5, 2, -2.0};
  DummySolver structure{3, 2, 0.5};
};

TEST(Loopback, two_solvers_solve_accept_skip_and_write) {
  Pair pair;
  Server server(patient_settings());
  auto soil_end = serve_aside(pair.soil, participant("soil", server.endpoint()));
  auto structure_end = serve_aside(pair.structure, participant("structure", server.endpoint()));
  auto solvers = server.wait_for({expected("soil"), expected("structure")}, {{"end", 1.5}});
  Solver& soil = *solvers.at("soil");
  Solver& structure = *solvers.at("structure");

  const auto mesh = soil.interfaces();
  ASSERT_EQ(mesh.size(), 1u);
  EXPECT_EQ(mesh[0].coordinates, pair.soil.interfaces()[0].coordinates);
  EXPECT_EQ(mesh[0].facets, pair.soil.interfaces()[0].facets);
  EXPECT_EQ(soil.probe_names(), std::vector<std::string>{"tip"});
  EXPECT_EQ(soil.probes(), std::vector<double>{1.0});

  soil.write_output(0);
  const StepRequest request{1, 0, 0.0, 0.1};
  InterfaceValues sent;
  const std::vector<double> u = {0.1, -0.0, 1e-310, 1e300, 1. / 3, 0, 0, 0, 0, 7};
  StepReport report = soil.solve_step(request, {{"wall", u}}, sent);
  for (std::size_t i = 0; i < u.size(); ++i) EXPECT_EQ(sent["wall"][i], 1 - 2 * u[i]);
  EXPECT_EQ(report.newton_iterations, 3);
  EXPECT_EQ(report.linear_iterations, 70);
  EXPECT_TRUE(report.interface_active);
  EXPECT_EQ(report.details["energy"].get<double>(), 0.1);

  report = structure.solve_step(request, {}, sent);
  EXPECT_FALSE(report.interface_active);
  EXPECT_EQ(sent["wall"], std::vector<double>(6, 1.0));

  structure.reject_step();
  const AcceptReport accepted = soil.accept_step(request, true);
  soil.write_output(0.1);
  EXPECT_EQ(accepted.probes, std::vector<double>{1.1});
  EXPECT_EQ(soil.probes(), std::vector<double>{1.1});
  EXPECT_FALSE(accepted.at_rest);
  EXPECT_EQ(accepted.proposed_dt, 0.25);
  EXPECT_EQ(accepted.details, (Json{{"heat", 1.0 / 3}}));
  EXPECT_TRUE(structure.accept_step(request, false).at_rest);
  EXPECT_EQ(soil.summary()["linear_solver"], "none");
  server.finish();

  EXPECT_EQ(soil_end.get(), "");
  EXPECT_EQ(structure_end.get(), "");
  EXPECT_EQ(pair.soil.calls,
            (std::vector<std::string>{"write 0.000000", "accept", "write 0.100000"}));
  EXPECT_EQ(pair.structure.calls, (std::vector<std::string>{"reject", "skip"}));
}

/// A soil that proposes 0.25 s, in a thread.
struct ProposingSoil {
  DummySolver solver{5, 2, -2.0};
  Server server{patient_settings()};
  std::future<std::string> end = serve_aside(solver, participant("soil", server.endpoint()));
  std::map<std::string, std::unique_ptr<Solver>> solvers =
      server.wait_for({expected("soil")}, {{"end", 1.5}});
  RemoteSolver& soil = static_cast<RemoteSolver&>(*solvers.at("soil"));
  const InterfaceValues u = {{"wall", std::vector<double>(10, 0.5)}};
  InterfaceValues sent;
};

TEST(Loopback, the_next_step_is_asked_for_behind_the_acceptance) {
  ProposingSoil run;
  RemoteSolver& soil = run.soil;
  ASSERT_TRUE(soil.takes_next_step());
  soil.solve_step({1, 0, 0.0, 0.1}, run.u, run.sent);
  soil.start_accept({1, 0, 0.0, 0.1}, true);
  soil.start_next({2, 0, 0.1, 0.1}, {{"wall", std::vector<double>(10, 1.0)}}, {0.1, 0.5});
  EXPECT_EQ(soil.finish_accept().proposed_dt, 0.25);
  soil.finish_solve(run.sent);
  EXPECT_EQ(run.sent["wall"], std::vector<double>(10, 0.1 + 1 - 2));
  soil.start_accept({2, 0, 0.1, 0.1}, true);
  soil.start_next({3, 0, 0.2, 0.1}, run.u, {0.1, {}});
  soil.finish_accept();
  soil.call_off_solve();  // solved, so it is rejected
  soil.solve_step({3, 0, 0.2, 0.05}, run.u, run.sent);
  EXPECT_EQ(soil.call_times().at("solve_step").count, 4);
  run.server.finish();
  EXPECT_EQ(run.end.get(), "");
  EXPECT_EQ(run.solver.calls, (std::vector<std::string>{"accept", "accept", "reject"}));
}

TEST(Loopback, a_next_step_by_another_proposal_is_passed) {
  for (const DtRange& range : {DtRange{0.3, {}}, DtRange{0.1, 0.25}}) {
    ProposingSoil run;
    RemoteSolver& soil = run.soil;
    soil.solve_step({1, 0, 0.0, 0.1}, run.u, run.sent);
    soil.start_accept({1, 0, 0.0, 0.1}, true);
    soil.start_next({2, 0, 0.1, 0.1}, run.u, range);
    soil.finish_accept();
    soil.call_off_solve();  // nothing to reject
    soil.solve_step({2, 0, 0.1, 0.05}, run.u, run.sent);
    run.server.finish();
    EXPECT_EQ(run.end.get(), "");
    EXPECT_EQ(run.solver.calls, std::vector<std::string>{"accept"});
  }
}

TEST(Loopback, a_next_step_is_asked_for_at_no_other_time) {
  ProposingSoil run;
  EXPECT_NE(message_of<ProtocolError>([&] {
              run.soil.start_next({1, 0, 0.0, 0.1}, run.u, {});
            }).find("step 1 asked for at the wrong time"),
            std::string::npos);
  run.server.finish();
}

}  // namespace
}  // namespace gabion::test::test_loopback
