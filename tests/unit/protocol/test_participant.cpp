// SPDX-License-Identifier: BSD-3-Clause
// Participant, driven by a loop of its own, against a coupler in this process; its C face too.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <functional>
#include <future>

#include "common/base/require.hpp"
#include "dummy_solver.hpp"
#include "protocol/gabion_participant.h"
#include "protocol/participant.hpp"
#include "protocol/wire/exchange.hpp"

namespace gabion::test::test_participant {
namespace {

const std::vector<double> coordinates = {0, 0, 0, 1, 0, 2};
const std::vector<std::int64_t> facets = {0, 1, 1, 2};

/// A code with a loop of its own: du/dt = f / 4 at every vertex, explicit Euler.
struct Loop {
  double u = 0, saved = 0;
  double own_dt = 1;           // [s]
  double fails_above = 1e300;  // [N]
  bool keeps = false;          // its state
  bool asks_force_kind = false;
  std::vector<std::string> calls;

  std::vector<std::byte> save() const {
    std::vector<std::byte> bytes(sizeof u);
    std::memcpy(bytes.data(), &u, sizeof u);
    return bytes;
  }
  void load(Participant& participant, std::span<const std::byte> bytes) {
    require(bytes.size() == sizeof u, "not a state of this loop");
    std::memcpy(&u, bytes.data(), sizeof u);
    participant.write_probes(std::vector<double>{u});
    calls.push_back(fmt_call("load", u));
  }

  void run(const ParticipantSettings& settings) {
    Participant participant(settings);
    participant.set_interface("wall", coordinates, 2, facets);
    participant.set_probes({"tip"}, std::vector<double>{u});
    participant.set_summary({{"method", "Euler"}});
    participant.set_output([this](double time) { calls.push_back(fmt_call("write", time)); });
    if (keeps) {
      participant.set_state([this] { return save(); },
                            [&](std::span<const std::byte> bytes) { load(participant, bytes); });
    }
    participant.initialize();
    while (participant.is_coupling_ongoing()) {
      if (participant.requires_writing_checkpoint()) {
        saved = u;
        calls.push_back(fmt_call("save", u));
      }
      step(participant, std::min(own_dt, participant.get_max_time_step_size()));
      if (participant.requires_reading_checkpoint()) {
        u = saved;
        calls.push_back(fmt_call("restore", u));
      }
      if (participant.is_time_window_complete()) calls.push_back("complete");
    }
    participant.finalize();
  }

  void step(Participant& participant, double dt) {
    if (asks_force_kind) {
      const bool mean = participant.force_kind("wall") == ForceKind::step_mean;
      calls.push_back(mean ? "mean force" : "force at the end");
    }
    const double force = participant.read_data("wall")[0];
    u += dt * force / 4;
    participant.write_data("wall", std::vector<double>(6, u));
    participant.write_probes(std::vector<double>{u});
    if (force > fails_above) return participant.fail_step("too much");
    StepReport report;
    report.newton_iterations = 7;
    participant.advance(dt, report);
  }

  static std::string fmt_call(const std::string& what, double value) {
    return what + " " + std::to_string(value).substr(0, 4);
  }
};

/// A coupler and the loop in a thread.
class OwnLoop : public testing::Test {
 protected:
  void start() {
    server_ = std::make_unique<Server>(patient_settings());
    const auto settings = participant("structure", server_->endpoint());
    end_ = std::async(std::launch::async,
                      [this, settings] { return message_of<Error>([&] { loop_.run(settings); }); });
    solvers_ = server_->wait_for({expected("structure")}, {{"end", 1.5}});
  }
  Solver& solver() { return *solvers_.at("structure"); }
  double solve(std::int64_t step, double force, double dt = 0.1) {
    InterfaceValues sent;
    dt_ = dt;
    const StepReport report =
        solver().solve_step({step, 0, time_, dt}, {{"wall", std::vector<double>(6, force)}}, sent);
    EXPECT_EQ(report.newton_iterations, 7);
    EXPECT_EQ(sent["wall"], std::vector<double>(6, sent["wall"][0]));
    return sent["wall"][0];
  }
  /// Accept a step with the dt of the last solution.
  AcceptReport accept(std::int64_t step, bool solved = true) {
    return solver().accept_step({step, 0, std::exchange(time_, time_ + dt_), dt_}, solved);
  }

  Loop loop_;
  std::unique_ptr<Server> server_;
  std::map<std::string, std::unique_ptr<Solver>> solvers_;
  std::future<std::string> end_;
  double time_ = 0, dt_ = 0.1;  // [s] of the accepted state, and of the step
};

TEST_F(OwnLoop, repeats_rejects_cuts_and_accepts) {
  start();
  solver().write_output(0);
  EXPECT_EQ(solve(1, 8), 0.2);
  EXPECT_EQ(solve(1, 4), 0.1);
  EXPECT_EQ(solve(1, 8), 0.2);
  solver().reject_step();
  solver().write_output(0);
  EXPECT_EQ(solve(1, 8, 0.05), 0.1);
  EXPECT_EQ(solver().accept_step({1, 0, 0, 0.05}, true).probes, std::vector<double>{0.1});
  solver().write_output(0.05);
  time_ = 0.05;
  solver().reject_step();
  EXPECT_NEAR(solve(2, 4), 0.2, 1e-16);
  EXPECT_EQ(accept(2, false).probes, std::vector<double>{0.1});  // asked, but not taken
  EXPECT_NEAR(solve(3, 4), 0.2, 1e-16);
  EXPECT_NEAR(accept(3).probes[0], 0.2, 1e-16);
  const std::vector<double> skipped = accept(4, false).probes;
  EXPECT_EQ(accept(5, false).probes, skipped);
  EXPECT_EQ(solver().summary()["method"], "Euler");
  server_->finish();
  EXPECT_EQ(end_.get(), "");
  EXPECT_EQ(loop_.calls,
            (std::vector<std::string>{"write 0.00", "save 0.00", "restore 0.00", "restore 0.00",
                                      "restore 0.00", "write 0.00", "complete", "write 0.05",
                                      "save 0.10", "restore 0.10", "complete"}));
}

TEST_F(OwnLoop, is_told_the_kinds_of_forces) {
  loop_.asks_force_kind = true;
  start();
  EXPECT_TRUE(solver().takes_force_kinds());
  solve(1, 8);
  accept(1);
  solver().set_force_kinds({{"wall", ForceKind::step_mean}});
  solve(2, 8);
  accept(2);
  server_->finish();
  EXPECT_EQ(end_.get(), "");
  EXPECT_EQ(loop_.calls, (std::vector<std::string>{"save 0.00", "force at the end", "complete",
                                                   "save 0.20", "mean force", "complete"}));
}

TEST_F(OwnLoop, saves_and_loads_between_steps) {
  loop_.keeps = true;
  start();
  EXPECT_TRUE(solver().keeps_state());
  solve(1, 8);
  accept(1);
  const State saved = solver().save_state_to("/no/such/folder/soil.h5");  // which is left alone
  EXPECT_EQ(saved.file, "");
  EXPECT_EQ(saved.facts, (Json{{"bytes", 8}}));
  solve(2, 4);
  accept(2);
  solve(3, 8);
  solver().reject_step();
  solver().load_state(saved);
  EXPECT_EQ(solver().probes(), std::vector<double>{0.2});
  for (int n = 0; n < 2; ++n) {
    EXPECT_EQ(solve(2, 4), 0.2 + 0.1 * 4 / 4);
    solver().reject_step();
  }
  server_->finish();
  EXPECT_EQ(end_.get(), "");
  EXPECT_EQ(loop_.calls, (std::vector<std::string>{"save 0.00", "complete", "save 0.20", "complete",
                                                   "save 0.30", "restore 0.30", "load 0.20",
                                                   "save 0.20", "restore 0.20", "restore 0.20"}));
}

TEST_F(OwnLoop, loads_before_the_first_step) {
  loop_.keeps = true;
  start();
  loop_.u = 0;
  const double u = 0.7;
  solver().load_state(pack_bytes(std::as_bytes(std::span(&u, 1))));
  EXPECT_EQ(solver().probes(), std::vector<double>{0.7});
  EXPECT_EQ(solve(9, 4), 0.7 + 0.1 * 4 / 4);
  accept(9);
  server_->finish();
  EXPECT_EQ(end_.get(), "");
}

TEST_F(OwnLoop, what_is_no_state_of_its_own_ends_the_run) {
  loop_.keeps = true;
  start();
  const std::string lost = message_of<ProtocolError>(
      [&] { solver().load_state(pack_bytes(std::vector<std::byte>(3))); });
  EXPECT_NE(lost.find("not a state of this loop"), std::string::npos) << lost;
  EXPECT_EQ(end_.get(), "not a state of this loop");
}

TEST_F(OwnLoop, is_not_asked_in_the_middle_of_a_step) {
  loop_.keeps = true;
  start();
  solve(1, 8);
  const std::string lost = message_of<ProtocolError>([&] { solver().save_state(); });
  EXPECT_NE(lost.find("asked for \"save\" in the middle of a step"), std::string::npos) << lost;
}

TEST_F(OwnLoop, keeps_no_state_by_itself) {
  start();
  EXPECT_FALSE(solver().keeps_state());
  const std::string lost = message_of<ProtocolError>([&] { solver().save_state(); });
  EXPECT_NE(lost.find("asked for \"save\", which this participant does not know"),
            std::string::npos)
      << lost;
}

TEST_F(OwnLoop, steps_that_do_not_follow_one_another_end_the_run) {
  start();
  solve(1, 8);
  accept(1);
  time_ = 0;
  const std::string lost = message_of<ProtocolError>([&] { solve(2, 8); });
  EXPECT_NE(lost.find("asks for step 2 from 0 s, but the accepted state is that of 0.1 s"),
            std::string::npos)
      << lost;
}

TEST_F(OwnLoop, what_was_rejected_is_not_accepted) {
  start();
  solve(1, 8);
  solver().reject_step();
  const std::string lost = message_of<ProtocolError>([&] { accept(1); });
  EXPECT_NE(lost.find("accepts step 1, which has no solution"), std::string::npos) << lost;
}

TEST_F(OwnLoop, a_failed_step_is_repeated) {
  loop_.fails_above = 5;
  start();
  const std::string failure = message_of<ConvergenceError>([&] { solve(1, 8); });
  EXPECT_NE(failure.find("too much"), std::string::npos) << failure;
  solver().reject_step();
  EXPECT_NEAR(solve(1, 4, 0.05), 0.05, 1e-16);
  accept(1);
  server_->finish();
  EXPECT_EQ(end_.get(), "");
}

TEST_F(OwnLoop, steps_of_its_own) {
  loop_.own_dt = 0.03;
  start();
  for (int n = 0; n < 2; ++n) EXPECT_NEAR(solve(1, 8), 0.2, 1e-15);
  accept(1);
  server_->finish();
  EXPECT_EQ(end_.get(), "");
  EXPECT_EQ(loop_.calls, (std::vector<std::string>{"save 0.00", "restore 0.00", "complete"}));
}

TEST_F(OwnLoop, the_couplers_end_is_told) {
  start();
  solve(1, 8);
  server_->abort("disk full");
  const std::string end = end_.get();
  EXPECT_NE(end.find("the coupler ended the run: disk full"), std::string::npos) << end;
}

/// Text that `body` throws when a participant, connected and with an open step, runs it.
std::string usage_error(const std::function<void(Participant&)>& body) {
  Server server(patient_settings());
  const auto settings = participant("structure", server.endpoint());
  auto end = std::async(std::launch::async, [&] {
    return message_of<UsageError>([&] {
      Participant participant(settings);
      participant.set_interface("wall", coordinates, 2, facets);
      participant.initialize();
      body(participant);
    });
  });
  auto solvers = server.wait_for({expected("structure")});
  InterfaceValues sent;
  const std::string lost = message_of<ProtocolError>([&] {
    solvers.at("structure")
        ->solve_step({1, 0, 0, 0.1}, {{"wall", std::vector<double>(6, 0)}}, sent);
  });
  EXPECT_NE(lost.find("ended before the run was finished, by an exception"), std::string::npos)
      << lost;
  return end.get();
}

bool says(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}
#define EXPECT_SAYS(text, part) EXPECT_PRED2(says, text, part)

TEST(Participant, wrong_calls_are_named) {
  const std::vector<double> six(6, 0.0);
  EXPECT_SAYS(usage_error([&](Participant& p) { p.set_interface("roof", six); }),
              "set_interface: allowed before initialize() only");
  EXPECT_SAYS(usage_error([&](Participant& p) { p.advance(0.1); }),
              "advance: call requires_writing_checkpoint()");
  EXPECT_SAYS(usage_error([&](Participant& p) { p.read_data("roof"); }),
              "found interface \"roof\", allowed: [\"wall\"]");
  EXPECT_SAYS(usage_error([&](Participant& p) {
                p.write_data("wall", {six.data(), 4});
              }),
              "write_data: found 4 values for \"wall\", allowed: 6");
  EXPECT_SAYS(usage_error([&](Participant& p) {
                p.requires_writing_checkpoint();
                p.write_data("wall", six);
                p.advance(0.2);
              }),
              "found dt 0.2 s, allowed: > 0 and at most 0.1 s");
  EXPECT_SAYS(usage_error([&](Participant& p) {
                p.requires_writing_checkpoint();
                p.advance(0.1);
              }),
              "nothing was written for \"wall\"");
}

TEST(Participant, wrong_settings_are_named) {
  auto settings = participant("structure", "tcp://127.0.0.1:9");
  EXPECT_SAYS(message_of<UsageError>([&] { Participant(settings).is_coupling_ongoing(); }),
              "initialize() comes first");
  EXPECT_SAYS(message_of<UsageError>([&] { Participant(settings).initialize(); }), "found none");
  EXPECT_SAYS(message_of<UsageError>([&] {
                Participant p(settings);
                p.set_interface("wall", coordinates, 2, std::vector<std::int64_t>{0, 3});
                p.initialize();
              }),
              "a facet names vertex 3, there are 3");
  EXPECT_SAYS(message_of<UsageError>([&] {
                Participant p(settings);
                p.set_interface("wall", {coordinates.data(), 5});
              }),
              "found 5 coordinates, allowed: num_vertices x 2");
  settings.dimension = 4;
  EXPECT_SAYS(message_of<UsageError>([&] { Participant{settings}; }), "found 4, allowed: 2 or 3");
}

TEST(ParticipantInC, failures_are_status_and_text) {
  EXPECT_EQ(gabion_create("structure", "tcp://127.0.0.1:9", 2, "heat"), nullptr);
  EXPECT_SAYS(gabion_last_error(nullptr), "found \"heat\", allowed: force, displacement");
  EXPECT_EQ(gabion_create(nullptr, "tcp://127.0.0.1:9", 2, "force"), nullptr);
  EXPECT_SAYS(gabion_last_error(nullptr), "name: found NULL");
  EXPECT_EQ(gabion_initialize(nullptr), GABION_ERROR_USAGE);

  gabion_participant* p = gabion_create("structure", "tcp://127.0.0.1:9", 2, "force");
  ASSERT_NE(p, nullptr);
  EXPECT_EQ(gabion_set_connect_deadline(p, 0), GABION_ERROR_USAGE);
  EXPECT_EQ(gabion_set_connect_deadline(p, 0.2), GABION_OK);
  EXPECT_STREQ(gabion_last_error(p), "");
  int answer = 0;
  EXPECT_EQ(gabion_is_coupling_ongoing(p, &answer), GABION_ERROR_USAGE);
  EXPECT_SAYS(gabion_last_error(p), "initialize() comes first");
  EXPECT_EQ(gabion_set_interface(p, "wall", 3, coordinates.data(), 2, 2, facets.data()), GABION_OK);
  EXPECT_EQ(gabion_set_force_kind(p, "wall", GABION_STEP_MEAN), GABION_ERROR_USAGE);
  EXPECT_SAYS(gabion_last_error(p), "found a participant that sends displacement");
  gabion_force_kind kind = GABION_STEP_MEAN;
  EXPECT_EQ(gabion_get_force_kind(p, "wall", &kind), GABION_ERROR_USAGE);
  EXPECT_SAYS(gabion_last_error(p), "initialize() comes first");
  EXPECT_EQ(gabion_write_data(p, "wall", coordinates.data(), 5), GABION_ERROR_USAGE);
  EXPECT_SAYS(gabion_last_error(p), "found 5 values for \"wall\", allowed: 6");
  EXPECT_EQ(gabion_initialize(p), GABION_ERROR_PROTOCOL);
  EXPECT_SAYS(gabion_last_error(p), "no answer from a coupler at tcp://127.0.0.1:9 within 0.2 s");
  gabion_destroy(p);

  gabion_participant* soil = gabion_create("soil", "tcp://127.0.0.1:9", 2, "displacement");
  ASSERT_NE(soil, nullptr);
  EXPECT_EQ(gabion_set_force_kind(soil, "wall", GABION_STEP_MEAN), GABION_ERROR_USAGE);
  EXPECT_SAYS(gabion_last_error(soil), "found interface \"wall\"");
  EXPECT_EQ(gabion_set_interface(soil, "wall", 3, coordinates.data(), 2, 2, facets.data()),
            GABION_OK);
  EXPECT_EQ(gabion_set_force_kind(soil, "wall", GABION_STEP_MEAN), GABION_OK);
  gabion_destroy(soil);
}

}  // namespace
}  // namespace gabion::test::test_participant
