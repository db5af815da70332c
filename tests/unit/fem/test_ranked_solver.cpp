// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "common/mechanics/ranks/ranked_solver.hpp"
#include "tests/support/mpi_main.hpp"

namespace gabion::test {
namespace {

/// Writes down what it was asked to do.
class Recorder : public Solver {
 public:
  std::vector<std::string> calls;
  int failing_rank = -1;
  bool fail_mildly = true;

  std::vector<InterfaceMesh> interfaces() const override { return {}; }
  std::vector<std::string> probe_names() const override { return {"p"}; }
  StepReport solve_step(const StepRequest& r, const InterfaceValues& received,
                        InterfaceValues& sent) override {
    calls.push_back("solve " + Json{r.step, r.iteration, r.time, r.dt, received}.dump());
    if (failing_rank == rank() && fail_mildly) throw ConvergenceError("no solution");
    if (failing_rank == rank()) throw Error("disk full");
    sent = received;
    return {.newton_iterations = 7};
  }
  AcceptReport accept_step(const StepRequest& r, bool solved) override {
    calls.push_back("accept " + Json{r.step, solved}.dump());
    return {{1.5}, true, 0.25};
  }
  void reject_step() override { calls.push_back("reject"); }
  void write_output(double time) override { calls.push_back("write " + Json(time).dump()); }
  std::vector<double> probes() const override { return {1.5}; }
  Json summary() const override { return {{"rank", rank()}}; }
};

const StepRequest request{3, 1, 0.1, 1.0 / 3};
const InterfaceValues values = {{"wall", {1.0 / 7, -2e-300}}};

TEST(RankedSolver, all_ranks_do_what_the_first_is_asked) {
  Recorder recorder;
  drive_ranks(comm(), recorder, [&](Solver& solver) {
    InterfaceValues sent;
    EXPECT_EQ(solver.solve_step(request, values, sent).newton_iterations, 7);
    EXPECT_EQ(sent, values);
    EXPECT_EQ(solver.probes(), std::vector<double>{1.5});
    EXPECT_EQ(solver.accept_step(request, true).proposed_dt, 0.25);
    solver.reject_step();
    solver.write_output(0.1);
    EXPECT_EQ(solver.summary().at("rank"), 0);
  });
  const std::vector<std::string> expected = {"solve " + Json{3, 1, 0.1, 1.0 / 3, values}.dump(),
                                             "accept [3,true]", "reject", "write 0.1"};
  EXPECT_EQ(recorder.calls, expected);
}

/// A failed step on one rank is one on all; the run goes on.
TEST(RankedSolver, convergence_failure_is_shared_and_survived) {
  Recorder recorder;
  recorder.failing_rank = size() - 1;
  drive_ranks(comm(), recorder, [&](Solver& solver) {
    InterfaceValues sent;
    EXPECT_THROW(solver.solve_step(request, values, sent), ConvergenceError);
    solver.reject_step();
  });
  EXPECT_EQ(recorder.calls.size(), 2u);
  EXPECT_EQ(recorder.calls.back(), "reject");
}

TEST(RankedSolver, other_failures_end_all_ranks) {
  Recorder recorder;
  recorder.failing_rank = size() - 1;
  recorder.fail_mildly = false;
  std::string text;
  try {
    drive_ranks(comm(), recorder, [&](Solver& solver) {
      InterfaceValues sent;
      solver.solve_step(request, values, sent);
    });
  } catch (const Error& error) {
    text = error.what();
  }
  EXPECT_NE(text.find("disk full"), std::string::npos) << text;
}

TEST(RankedSolver, failure_of_the_driver_releases_the_others) {
  Recorder recorder;
  EXPECT_THROW(drive_ranks(comm(), recorder, [](Solver&) { throw ProtocolError("coupler lost"); }),
               Error);
  EXPECT_TRUE(recorder.calls.empty());
}

}  // namespace
}  // namespace gabion::test
