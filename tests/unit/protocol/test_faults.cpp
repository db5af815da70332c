// SPDX-License-Identifier: BSD-3-Clause
// Peers that die, freeze, come late, lie, or fail. Processes are forked before any socket exists
// in this one and learn the endpoint through a pipe.
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <csignal>
#include <future>
#include <latch>
#include <limits>
#include <thread>

#include "common/base/interrupt.hpp"
#include "common/run/repeated_failure.hpp"
#include "dummy_solver.hpp"
#include "protocol/serve.hpp"
#include "raw_participant.hpp"
#include "tests/support/expect_error.hpp"

namespace gabion::test::test_faults {
namespace {

void sleep_for(double seconds) {
  std::this_thread::sleep_for(std::chrono::duration<double>(seconds));
}

/// A forked process that runs body(endpoint) once it is told the endpoint; its exit code is 0, or
/// that of the Error that body throws.
class Child {
 public:
  explicit Child(const std::function<void(const std::string&)>& body) {
    if (pipe(pipe_.data()) != 0) throw std::runtime_error("pipe");
    pid_ = fork();
    if (pid_ != 0) return;
    close(pipe_[1]);
    std::array<char, 200> endpoint{};
    if (read(pipe_[0], endpoint.data(), endpoint.size() - 1) <= 0) _exit(99);
    try {
      body(endpoint.data());
    } catch (const Error& problem) {
      _exit(problem.exit_code());
    }
    _exit(0);
  }
  ~Child() {
    if (!reaped_) {
      signal(SIGKILL);
      exit_status();
    }
    close(pipe_[0]);
    close(pipe_[1]);
  }
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;

  void tell(const std::string& endpoint) {
    ASSERT_EQ(write(pipe_[1], endpoint.data(), endpoint.size()),
              static_cast<ssize_t>(endpoint.size()));
  }
  void signal(int number) const { kill(pid_, number); }
  pid_t pid() const { return pid_; }
  /// Wait for the end; 128 + signal when one ended it.
  int exit_status() {
    int status = 0;
    waitpid(pid_, &status, 0);
    reaped_ = true;
    return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  }

 private:
  pid_t pid_ = 0;
  std::array<int, 2> pipe_{};
  bool reaped_ = false;
};

/// A participant process that does this in its solve_step.
std::function<void(const std::string&)> participant_that(const std::string& name,
                                                         const std::function<void()>& on_solve) {
  return [name, on_solve](const std::string& endpoint) {
    DummySolver solver(3, 2, 1.0);
    solver.on_solve = [on_solve](const StepRequest&) { on_solve(); };
    ParticipantSettings settings = participant(name, endpoint);
    settings.exit_when_coupler_is_lost = true;
    Connection connection(settings);
    serve(solver, connection);
  };
}

constexpr double for_ever = 500;  // [s], longer than a test may take

#define EXPECT_CONTAINS(text, part) EXPECT_NE((text).find(part), std::string::npos) << (text)

/// A coupler in this process, participants in others.
class Processes : public ::testing::Test {
 protected:
  using Body = std::function<void(const std::string&)>;

  /// Fork a participant that waits for its coupler; before start().
  Child& fork_participant(const std::string& name, const Body& body) {
    names_.push_back(name);
    return *children_.emplace_back(std::make_unique<Child>(body));
  }
  Child& fork_that(const std::string& name, const std::function<void()>& on_solve) {
    return fork_participant(name, participant_that(name, on_solve));
  }
  Child& fork_slow(const std::string& name, double seconds) {
    return fork_that(name, [seconds] { sleep_for(seconds); });
  }
  /// Shake hands with all participants.
  void start(const ServerSettings& settings = patient_settings()) {
    server_ = std::make_unique<Server>(settings);
    std::vector<Expected> all;
    for (const auto& name : names_) all.push_back(expected(name));
    for (const auto& child : children_) child->tell(server_->endpoint());
    solvers_ = server_->wait_for(all);
  }
  RemoteSolver& solver(const std::string& name) {
    return static_cast<RemoteSolver&>(*solvers_.at(name));
  }
  void solve(const std::string& name, const StepRequest& request = {1, 0, 0, 0.1}) {
    InterfaceValues sent;
    solver(name).solve_step(request, {}, sent);
  }
  template <class Thrown = ProtocolError>
  std::string error_of_solve(const std::string& name, const StepRequest& request = {1, 0, 0, 0.1}) {
    return message_of<Thrown>([&] { solve(name, request); });
  }

  std::vector<std::string> names_;
  std::vector<std::unique_ptr<Child>> children_;
  std::unique_ptr<Server> server_;
  std::map<std::string, std::unique_ptr<Solver>> solvers_;
};

// The deadlines of these tests do not pass: a death that they report was noticed before.

TEST_F(Processes, killed_participant_is_named) {
  Child& structure = fork_that("structure", [] { raise(SIGKILL); });
  Child& soil = fork_slow("soil", 0);
  start();
  const std::string error = error_of_solve("structure", {57, 3, 0, 0.1});
  EXPECT_CONTAINS(error, "participant \"structure\" (fem_solver, pid " +
                             std::to_string(structure.pid()) +
                             ") has died: no process; last sign of life");
  EXPECT_CONTAINS(error, "in phase \"solve_step 57 iteration 3\"");
  // The failure is final, and the survivor is told.
  EXPECT_CONTAINS(message_of<ProtocolError>([&] { solver("soil").reject_step(); }),
                  "failed before: participant \"structure\"");
  EXPECT_EQ(soil.exit_status(), 4);
}

TEST_F(Processes, death_of_a_participant_that_is_not_awaited_is_noticed_too) {
  fork_slow("structure", for_ever);
  Child& soil = fork_slow("soil", 0);
  start();
  soil.signal(SIGKILL);
  EXPECT_CONTAINS(error_of_solve("structure"), "participant \"soil\" (mpm_solver, pid");
}

TEST_F(Processes, participant_that_exits_with_zero_too_early_is_noticed) {
  fork_that("soil", [] { _exit(0); });
  start();
  EXPECT_CONTAINS(error_of_solve("soil"), "has died: no process");
}

TEST_F(Processes, stopped_participant_is_reported_after_the_silence_deadline) {
  fork_that("soil", [] { raise(SIGSTOP); });
  ServerSettings settings = patient_settings();
  settings.deadlines.silence = 2;
  start(settings);
  const std::string error = error_of_solve("soil", {2, 1, 0, 0.1});
  EXPECT_CONTAINS(error, "is silent for ");
  EXPECT_CONTAINS(error, "limit 2 s, option protocol/silence_deadline");
  EXPECT_CONTAINS(error, "its process is stopped");
  EXPECT_CONTAINS(error, "solve_step 2 iteration 1");
}

TEST_F(Processes, busy_participant_outlives_the_silence_deadline) {
  Child& soil = fork_slow("soil", 2.5);
  ServerSettings settings = patient_settings();
  settings.deadlines.silence = 2;
  start(settings);
  solve("soil");
  const CallTimes& times = solver("soil").last_call();
  EXPECT_GE(times.busy_seconds, 2.5);
  EXPECT_EQ(solver("soil").last_busy_seconds(), times.busy_seconds);
  EXPECT_GT(times.seconds, times.busy_seconds);
  server_->finish();
  EXPECT_EQ(soil.exit_status(), 0);
}

TEST_F(Processes, busy_coupler_outlives_the_silence_deadline) {
  Child& soil = fork_slow("soil", 0);
  ServerSettings settings = patient_settings();
  settings.deadlines.silence = 2;
  start(settings);
  sleep_for(2.5);  // the coupler computes
  solve("soil");
  server_->finish();
  EXPECT_EQ(soil.exit_status(), 0);
}

TEST_F(Processes, alive_but_never_answering_is_reported_after_the_answer_deadline) {
  fork_slow("soil", for_ever);
  ServerSettings settings = patient_settings();
  settings.deadlines.answer = 0.5;
  start(settings);
  const std::string error = error_of_solve("soil");
  EXPECT_CONTAINS(error, "is alive but has not answered");
  EXPECT_CONTAINS(error, "protocol/answer_deadline");
}

/// A coupler process that does nothing after the handshake, and a participant in a thread of ours.
class DyingCoupler {
 public:
  DyingCoupler(bool asks_to_solve, double silence_deadline)
      : child_([this, asks_to_solve, silence_deadline](const std::string&) {
          ServerSettings settings = patient_settings();
          settings.deadlines.silence = silence_deadline;
          Server server(settings);
          const std::string endpoint = server.endpoint();
          if (write(to_parent_[1], endpoint.data(), endpoint.size()) < 0) _exit(98);
          auto solvers = server.wait_for({expected("soil")});
          InterfaceValues sent;
          if (asks_to_solve) solvers.at("soil")->solve_step({1, 0, 0, 0.1}, {}, sent);
          sleep_for(for_ever);
        }) {
    child_.tell("go");
    std::array<char, 200> endpoint{};
    if (read(to_parent_[0], endpoint.data(), endpoint.size() - 1) > 0) endpoint_ = endpoint.data();
  }
  const std::string& endpoint() const { return endpoint_; }
  Child& child() { return child_; }

 private:
  std::array<int, 2> to_parent_ = [] {
    std::array<int, 2> ends{};
    if (pipe(ends.data()) != 0) throw std::runtime_error("pipe");
    return ends;
  }();
  Child child_;
  std::string endpoint_;
};

TEST(Faults, waiting_participant_notices_the_couplers_death) {
  DyingCoupler coupler(false, 50);
  DummySolver solver(3, 2, 1.0);
  Connection connection(participant("soil", coupler.endpoint()));
  connection.handshake(solver);
  coupler.child().signal(SIGKILL);
  const std::string error = message_of<ProtocolError>([&] { serve(solver, connection); });
  EXPECT_CONTAINS(error,
                  "the coupler (pid " + std::to_string(coupler.child().pid()) + ") has died");
}

TEST(Faults, waiting_participant_notices_a_stopped_coupler) {
  DyingCoupler coupler(false, 1);
  DummySolver solver(3, 2, 1.0);
  Connection connection(participant("soil", coupler.endpoint()));
  connection.handshake(solver);
  coupler.child().signal(SIGSTOP);
  const std::string error = message_of<ProtocolError>([&] { serve(solver, connection); });
  EXPECT_CONTAINS(error, "the coupler (pid");
  EXPECT_CONTAINS(error, "its process is stopped");
}

/// Only its heartbeat thread can end the process: its solution takes longer than the test may.
TEST(Faults, busy_participant_ends_when_the_coupler_dies) {
  std::array<int, 2> busy{};
  ASSERT_EQ(pipe(busy.data()), 0);
  Child soil(participant_that("soil", [busy] {
    if (write(busy[1], "!", 1) == 1) sleep_for(for_ever);
  }));
  DyingCoupler coupler(true, 50);
  soil.tell(coupler.endpoint());
  char came = 0;
  ASSERT_EQ(read(busy[0], &came, 1), 1);
  coupler.child().signal(SIGKILL);
  coupler.child().exit_status();
  EXPECT_EQ(soil.exit_status(), 4);
  close(busy[0]);
  close(busy[1]);
}

TEST(Faults, absent_participant_meets_the_connect_deadline) {
  ServerSettings settings = patient_settings();
  settings.deadlines.connect = 0.3;
  Server server(settings);
  expect_error<ProtocolError>(
      [&] {
        server.wait_for({expected("soil"), expected("structure")});
      },
      {"soil", "structure", server.endpoint(), "protocol/connect_deadline"});
}

TEST(Faults, absent_coupler_meets_the_connect_deadline) {
  std::string endpoint;
  {
    Server gone(patient_settings());
    endpoint = gone.endpoint();
  }
  ParticipantSettings settings = participant("soil", endpoint);
  settings.connect_deadline = 0.3;
  DummySolver solver(3, 2, 1.0);
  const std::string error = message_of<ProtocolError>([&] {
    Connection connection(settings);
    serve(solver, connection);
  });
  EXPECT_CONTAINS(error, endpoint);
  EXPECT_CONTAINS(error, "--connect-deadline");
}

/// A coupler in this thread, participants in others.
class Threads : public ::testing::Test {
 protected:
  /// Unless the run was finished, the server's end ends the participant.
  void TearDown() override {
    solvers_.clear();
    server_.reset();
    if (end_.valid()) end_.wait();
  }
  Solver& connect() {
    end_ = std::async(std::launch::async, [this, endpoint = server_->endpoint()] {
      return message_of<std::exception>([&] {
        Connection connection(participant("soil", endpoint));
        serve(solver_, connection, welcomed_);
      });
    });
    solvers_ = server_->wait_for({expected("soil")});
    return *solvers_.at("soil");
  }
  std::string participants_error() { return end_.get(); }

  DummySolver solver_{3, 2, 1.0};
  std::function<void()> welcomed_;
  std::unique_ptr<Server> server_ = std::make_unique<Server>(patient_settings());
  std::map<std::string, std::unique_ptr<Solver>> solvers_;
  std::future<std::string> end_;
  InterfaceValues sent_;
};

TEST_F(Threads, failed_step_is_a_convergence_error_and_the_run_goes_on) {
  solver_.on_solve = [](const StepRequest& request) {
    if (request.dt > 0.06) throw ConvergenceError("Newton: residual 3.1 after 20 iterations");
  };
  Solver& soil = connect();
  EXPECT_EQ(message_of<ConvergenceError>([&] {
              soil.solve_step({1, 0, 0, 0.1}, {}, sent_);
            }),
            "participant \"soil\": Newton: residual 3.1 after 20 iterations");
  soil.reject_step();
  soil.solve_step({1, 0, 0, 0.05}, {}, sent_);
  EXPECT_EQ(soil.accept_step({1, 0, 0, 0.05}, true).probes, std::vector<double>{1.05});
  server_->finish();
  EXPECT_EQ(participants_error(), "");
}

TEST_F(Threads, a_step_that_fails_at_any_dt_says_so) {
  std::string cause;
  solver_.on_solve = [&](const StepRequest&) { throw ConvergenceError("too much", cause); };
  Solver& soil = connect();
  for (const auto& [thrown, told] :
       {std::pair("iteration_limit", "other"), {fails_at_any_dt, fails_at_any_dt}}) {
    cause = thrown;
    try {
      soil.solve_step({1, 0, 0, 0.1}, {}, sent_);
      ADD_FAILURE() << thrown;
    } catch (const ConvergenceError& error) {
      EXPECT_EQ(error.cause(), told);
    }
    soil.reject_step();
  }
  server_->finish();
  EXPECT_EQ(participants_error(), "");
}

TEST_F(Threads, any_other_error_of_a_solver_ends_the_run_with_its_text) {
  solver_.on_solve = [](const StepRequest&) { throw std::runtime_error("disk full"); };
  Solver& soil = connect();
  const std::string error = message_of<ProtocolError>([&] {
    soil.solve_step({1, 0, 0, 0.1}, {}, sent_);
  });
  EXPECT_CONTAINS(error, "participant \"soil\" (mpm_solver, pid");
  EXPECT_CONTAINS(error, "ended the run: disk full");
  EXPECT_EQ(participants_error(), "disk full");
}

TEST_F(Threads, what_fails_after_the_welcome_ends_the_run_with_its_text) {
  welcomed_ = [] { throw std::runtime_error("no folder"); };
  Solver& soil = connect();
  EXPECT_CONTAINS(message_of<ProtocolError>([&] {
                    soil.solve_step({1, 0, 0, 0.1}, {}, sent_);
                  }),
                  "ended the run: no folder");
  EXPECT_EQ(participants_error(), "no folder");
}

TEST_F(Threads, values_that_are_not_finite_are_reported) {
  solver_.spoil = [](InterfaceValues& sent) {
    sent["wall"][3] = std::numeric_limits<double>::infinity();
  };
  Solver& soil = connect();
  EXPECT_CONTAINS(message_of<ProtocolError>([&] {
                    soil.solve_step({1, 0, 0, 0.1}, {}, sent_);
                  }),
                  "\"force:wall\" is inf at vertex 1, component 1");
}

TEST_F(Threads, couplers_abort_reaches_the_participant) {
  connect();
  server_->abort("dt_min reached");
  EXPECT_EQ(participants_error(), "the coupler ended the run: dt_min reached");
}

TEST_F(Threads, coupler_that_ends_without_finish_is_a_failure) {
  connect();
  solvers_.clear();
  server_.reset();
  EXPECT_CONTAINS(participants_error(), "the coupler ended without finishing the run");
}

TEST_F(Threads, accepting_without_solution_is_refused) {
  Solver& soil = connect();
  EXPECT_CONTAINS(message_of<ProtocolError>([&] {
                    soil.accept_step({4, 0, 0, 0.1}, true);
                  }),
                  "accepts step 4, which has no solution");
}

TEST_F(Threads, wrong_sizes_given_by_the_coupler_are_refused_before_they_are_sent) {
  Solver& soil = connect();
  EXPECT_CONTAINS(message_of<ProtocolError>([&] {
                    soil.solve_step({1, 0, 0, 0.1}, {{"wall", std::vector<double>(5)}}, sent_);
                  }),
                  "\"displacement:wall\": expected 3 x 2 values, found 5");
}

/// Each solution waits until the other one is under way.
TEST_F(Threads, two_solvers_work_at_once) {
  DummySolver a(3, 2, 1.0);
  DummySolver b(3, 2, 1.0);
  std::latch both_solve(2);
  a.on_solve = b.on_solve = [&](const StepRequest&) { both_solve.arrive_and_wait(); };
  const auto run = [this](DummySolver& solver, const char* name) {
    return std::async(std::launch::async, [this, &solver, name] {
      Connection connection(participant(name, server_->endpoint()));
      serve(solver, connection);
    });
  };
  auto end_a = run(a, "soil");
  auto end_b = run(b, "structure");
  solvers_ = server_->wait_for({expected("soil"), expected("structure")});
  auto& soil = static_cast<RemoteSolver&>(*solvers_.at("soil"));
  auto& structure = static_cast<RemoteSolver&>(*solvers_.at("structure"));
  soil.start_solve({1, 0, 0, 0.1}, {});
  expect_error<ProtocolError>(
      [&] {
        soil.start_solve({1, 0, 0, 0.1}, {});
      },
      {"asked before the answer"});
  structure.start_solve({1, 0, 0, 0.1}, {});
  soil.finish_solve(sent_);
  structure.finish_solve(sent_);
  server_->finish();
  end_a.get();
  end_b.get();
}

/// A participant that answers a solve_step with this message; the coupler's error.
std::string error_on_answer(const std::function<void(RawParticipant&, const Message&)>& answer) {
  Server server(patient_settings());
  RawParticipant raw(server.endpoint(), "raw");
  raw.send(to_message(good_hello("soil")));
  auto solvers = server.wait_for({expected("soil")});
  raw.receive();
  auto& soil = static_cast<RemoteSolver&>(*solvers.at("soil"));
  soil.start_solve({1, 0, 0, 0.1}, {});
  answer(raw, raw.receive());
  InterfaceValues sent;
  return message_of<ProtocolError>([&] { soil.finish_solve(sent); });
}

Message solved(const Message& request, std::int64_t num_vertices, double value) {
  Message reply;
  reply.type = "solved";
  reply.sequence = request.sequence;
  reply.fields = {{"newton_iterations", 1},
                  {"linear_iterations", 1},
                  {"interface_active", true},
                  {"details", Json::object()},
                  {"busy_seconds", 0.0}};
  reply.add("force:wall", {num_vertices, 2},
            std::vector<double>(static_cast<std::size_t>(2 * num_vertices), value));
  return reply;
}

TEST(Lies, wrong_answers_are_reported) {
  EXPECT_EQ(error_on_answer([](auto& raw, auto& request) { raw.send(solved(request, 3, 1)); }), "");
  EXPECT_CONTAINS(
      error_on_answer([](auto& raw, auto& request) { raw.send(solved(request, 4, 1)); }),
      "participant \"soil\" answered wrongly: message \"solved\", array \"force:wall\": "
      "expected shape [3, 2], found [4, 2]");
  EXPECT_CONTAINS(
      error_on_answer([](auto& raw, auto& request) { raw.send(solved(request, 3, NAN)); }),
      "participant \"soil\" answered wrongly: \"force:wall\" is nan at vertex 0, component 0");
  EXPECT_CONTAINS(error_on_answer([](auto& raw, auto& request) {
                    Message reply = solved(request, 3, 1);
                    reply.sequence += 1;
                    raw.send(reply);
                  }),
                  "answered \"solved\" to request 2, expected an answer to 1");
  EXPECT_CONTAINS(error_on_answer([](auto& raw, auto& request) {
                    Message reply = solved(request, 3, 1);
                    reply.type = "accepted";
                    raw.send(reply);
                  }),
                  "answered \"solve_step\" with \"accepted\"");
  EXPECT_CONTAINS(error_on_answer([](auto& raw, auto&) { raw.send_frames({"garbage"}); }),
                  "sent a message that is not understood: header frame is not JSON");
  EXPECT_CONTAINS(error_on_answer([](auto& raw, auto& request) {
                    Message reply = solved(request, 3, 1);
                    reply.arrays.clear();
                    raw.send(reply);
                  }),
                  "expected an array \"force:wall\"");
}

class Signals : public Threads {
 protected:
  void SetUp() override { interrupt::install(); }
  void TearDown() override {
    interrupt::clear();
    Threads::TearDown();
    std::signal(SIGTERM, SIG_DFL);
    std::signal(SIGINT, SIG_DFL);
  }
};

/// The solution, which brings the signal, takes until the wait for it has ended.
TEST_F(Signals, signal_ends_a_wait) {
  std::promise<void> wait_ended;
  solver_.on_solve = [self = pthread_self(), ended = wait_ended.get_future().share()](auto&) {
    pthread_kill(self, SIGTERM);
    ended.wait_for(std::chrono::seconds(50));
  };
  Solver& soil = connect();
  int code = 0;
  try {
    soil.solve_step({1, 0, 0, 0.1}, {}, sent_);
  } catch (const Interrupted& problem) {
    code = problem.exit_code();
  }
  wait_ended.set_value();
  EXPECT_EQ(code, 128 + SIGTERM);
}

/// Answers that come without delay do not hide a signal.
TEST_F(Signals, signal_ends_a_run_of_quick_answers) {
  Solver& soil = connect();
  std::raise(SIGTERM);
  EXPECT_EQ(error_of<Interrupted>([&] {
              soil.solve_step({1, 0, 0, 0.1}, {}, sent_);
              soil.reject_step();
            }),
            "interrupted by signal 15 (Terminated)");
}

/// A launcher ends the coupler too when one of its processes has died.
TEST_F(Processes, death_of_a_peer_is_the_message_even_when_a_launcher_ends_the_coupler) {
  Child& soil = fork_that("soil", [] { raise(SIGKILL); });
  interrupt::install();
  start();
  std::thread launcher([&, self = pthread_self()] {
    soil.exit_status();
    pthread_kill(self, SIGTERM);
  });
  EXPECT_CONTAINS(error_of_solve<Error>("soil"), "participant \"soil\" (mpm_solver, pid");
  launcher.join();
  solvers_.clear();
  server_.reset();
  interrupt::clear();
  std::signal(SIGTERM, SIG_DFL);
  std::signal(SIGINT, SIG_DFL);
}

}  // namespace
}  // namespace gabion::test::test_faults
