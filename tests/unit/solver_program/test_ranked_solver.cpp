// SPDX-License-Identifier: BSD-3-Clause
// A solver on several ranks follows the frames that the first one gets.
#include <gtest/gtest.h>

#include <filesystem>
#include <functional>

#include "common/checkpoint/state_file.hpp"
#include "common/hdf5/hdf5_reader.hpp"
#include "common/mechanics/ranks/sum.hpp"
#include "common/run/repeated_failure.hpp"
#include "protocol/serve.hpp"
#include "protocol/wire/codec.hpp"
#include "protocol/wire/exchange.hpp"
#include "protocol/wire/force_kinds.hpp"
#include "solver_program/ranked_requests.hpp"
#include "solver_program/ranked_solver.hpp"
#include "solver_program/ranked_state.hpp"
#include "tests/support/expect_error.hpp"
#include "tests/support/mpi_main.hpp"

namespace gabion::test::test_ranked_solver {
namespace {

/// Writes down what it was asked to do.
class Recorder : public Solver, public TakesStart {
 public:
  std::vector<std::string> calls;
  int failing_rank = -1;
  bool fail_mildly = true;
  std::string cause = "other";                           // of the mild failure
  std::vector<double> part = {1.0 / 3, double(rank())};  // of the state

  std::vector<InterfaceMesh> interfaces() const override { return {{"wall", 2, {0, 0}, 0, {}}}; }
  std::vector<std::string> probe_names() const override { return {"p"}; }
  bool takes_force_kinds() const override { return true; }
  void set_force_kinds(const ForceKinds& kinds) override {
    calls.push_back(kinds.at("wall") == ForceKind::step_mean ? "mean forces" : "forces at the end");
    if (failing_rank == rank()) throw Error("no mean forces here");
  }
  void set_start(const InterfaceValues& displacements) override {
    calls.push_back("start " + Json(displacements).dump());
    if (failing_rank == rank()) throw ConfigError("soil inside");
  }
  StepReport solve_step(const StepRequest& r, const InterfaceValues& received,
                        InterfaceValues& sent) override {
    calls.push_back("solve " + Json{r.step, r.iteration, r.time, r.dt, received}.dump());
    if (failing_rank == rank() && fail_mildly) throw ConvergenceError("no solution", cause);
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
  bool keeps_state() const override { return true; }
  State save_state() override {
    State state;
    state.reals["part"] = part;
    return state;
  }
  void load_state(const State& state) override { part = state.reals.at("part"); }
};

/// Requests of a coupler that has written them down beforehand, and what was answered.
class Script : public RequestSource {
 public:
  explicit Script(std::vector<Message> requests) : requests_(std::move(requests)) {}

  Message next_request(std::vector<std::string>* frames) override {
    if (next_ == requests_.size()) throw ProtocolError("coupler lost");
    const EncodedMessage encoded = encode(requests_[next_++]);
    std::vector<std::string> bytes = {encoded.header};
    bytes.insert(bytes.end(), encoded.payloads.begin(), encoded.payloads.end());
    Message request = decode(bytes);
    if (frames) *frames = std::move(bytes);
    return request;
  }
  void reply(Message message) override {
    if (message.type == unsendable) throw ProtocolError("queue is full");
    answers.push_back(std::move(message));
  }

  std::vector<Message> answers;
  std::string unsendable;

 private:
  std::vector<Message> requests_;
  std::size_t next_ = 0;
};

/// Let all ranks follow these requests.
void follow(Script& script, Solver& inner) {
  RankedSolver solver(comm(), inner);
  if (rank() == 0) {
    LeadingRequests requests(comm(), script);
    answer_requests(solver, force(), displacement(), requests);
  } else {
    FollowingRequests requests(comm());
    answer_requests(solver, force(), displacement(), requests);
  }
}

const StepRequest step{1, 3, 0.1, 1.0 / 3};
const InterfaceValues values = {{"wall", {1.0 / 7, -2e-300}}};

Message solve_request() {
  Message request = new_message("solve_step");
  put(request, step);
  put_values(request, "force", {{"wall", 2, {0, 0}, 0, {}}}, values);
  return request;
}

Message accept_request() {
  Message request = new_message("accept_step", {{"solved", true}, {"write_output", false}});
  put(request, step);
  return request;
}

std::vector<std::string> types_of(const std::vector<Message>& messages) {
  std::vector<std::string> types;
  for (const Message& message : messages) types.push_back(message.type);
  return types;
}

/// The first rank throws the error itself; the others are told whose it is.
void expect_failure(Script& script, Solver& solver, const std::string& text) {
  const std::string told = rank() == 0 ? text : "rank 0 failed: " + text;
  expect_error<ProtocolError>([&] { follow(script, solver); }, {told});
}

Message start_request() {
  Message request = new_message("set_start");
  put_values(request, "force", {{"wall", 2, {0, 0}, 0, {}}}, values);
  return request;
}

TEST(RankedSolver, all_ranks_are_told_where_the_run_starts) {
  Recorder solver;
  Script script({start_request(), new_message("finish")});
  follow(script, solver);
  EXPECT_EQ(solver.calls, std::vector<std::string>{"start " + Json(values).dump()});
  if (rank() == 0) {
    EXPECT_EQ(types_of(script.answers), (std::vector<std::string>{"start_set", "finished"}));
  }
  Recorder failing;
  failing.failing_rank = num_ranks(comm()) - 1;
  RankedSolver ranked(comm(), failing);
  EXPECT_TRUE(ranked.takes_start());
  expect_error<ConfigError>([&] { ranked.set_start(values); }, {"soil inside"});
}

TEST(RankedSolver, a_start_comes_before_the_first_accepted_step) {
  Recorder solver;
  Script script({solve_request(), accept_request(), start_request()});
  expect_error<ProtocolError>([&] { follow(script, solver); },  // on all ranks
                              {"\"set_start\" after an accepted step"});
}

TEST(RankedSolver, all_ranks_do_what_the_first_is_asked) {
  Recorder recorder;
  Script script({new_message("write_output", {{"time", 0.0}}), solve_request(), accept_request(),
                 new_message("reject_step"), new_message("summarize"), new_message("finish")});
  follow(script, recorder);
  const std::vector<std::string> expected = {
      "write 0.0", "solve " + Json{1, 3, 0.1, 1.0 / 3, values}.dump(), "accept [1,true]", "reject"};
  EXPECT_EQ(recorder.calls, expected);
  if (rank() != 0) return;
  EXPECT_EQ(types_of(script.answers),
            (std::vector<std::string>{"written", "solved", "accepted", "rejected", "summary",
                                      "finished"}));
  EXPECT_EQ(script.answers[1].reals("displacement:wall", {1, 2}), values.at("wall"));
  const Json& summary = script.answers[4].fields.at("summary");
  EXPECT_EQ(summary.at("rank"), 0);
  // Programs of MPI take megabytes at least, ranks alike within a factor.
  const auto largest = summary.at("peak_memory").at("largest_rank").get<double>();
  const auto all = summary.at("peak_memory").at("all_ranks").get<double>();
  EXPECT_GT(largest, 1e6);
  EXPECT_GE(all, largest);
  EXPECT_LE(all, size() * largest);
}

/// A failed step on one rank is one on all; the run goes on, and the step can be repeated.
TEST(RankedSolver, convergence_failure_is_shared_and_survived) {
  Recorder recorder;
  recorder.failing_rank = size() - 1;
  Script script({solve_request(), new_message("reject_step"), solve_request(),
                 new_message("reject_step"), new_message("finish")});
  follow(script, recorder);
  EXPECT_EQ(recorder.calls.size(), 4u);
  EXPECT_EQ(recorder.calls.back(), "reject");
  if (rank() != 0) return;
  EXPECT_EQ(types_of(script.answers),
            (std::vector<std::string>{"failed", "rejected", "failed", "rejected", "finished"}));
  EXPECT_EQ(script.answers[0].text("reason"), "no solution");
  EXPECT_FALSE(script.answers[0].fields.contains("at_any_dt"));
}

TEST(RankedSolver, the_cause_of_a_failure_is_known_on_all_ranks) {
  Recorder recorder;
  recorder.failing_rank = size() - 1;
  recorder.cause = fails_at_any_dt;
  RankedSolver solver(comm(), recorder);
  InterfaceValues sent;
  try {
    solver.solve_step(step, values, sent);
    ADD_FAILURE();
  } catch (const ConvergenceError& error) {
    EXPECT_EQ(error.cause(), fails_at_any_dt);
  }
  Script script({solve_request(), new_message("reject_step"), new_message("finish")});
  follow(script, recorder);
  if (rank() == 0) {
    EXPECT_TRUE(script.answers[0].boolean("at_any_dt"));
  }
}

TEST(RankedSolver, other_failures_end_all_ranks) {
  Recorder recorder;
  recorder.failing_rank = size() - 1;
  recorder.fail_mildly = false;
  Script script({solve_request()});
  expect_error<Error>([&] { follow(script, recorder); }, {"disk full"});
}

/// The worst of several failures is told, on every rank.
TEST(RankedSolver, the_worst_failure_is_agreed) {
  class Failing : public Recorder {
    void write_output(double) override {
      if (rank() == 0) throw ConvergenceError("a mild one");
      throw ConfigError("no folder on rank " + std::to_string(rank()));
    }
  } failing;
  Script script({new_message("write_output", {{"time", 0.0}})});
  if (size() == 1) {
    expect_error<ConvergenceError>([&] { follow(script, failing); }, {"a mild one"});
  } else {
    expect_error<ConfigError>([&] { follow(script, failing); }, {"no folder on rank 1"});
  }
}

TEST(RankedSolver, every_rank_gets_its_part_of_a_state_back) {
  Recorder recorder;
  const std::vector<double> part = recorder.part;
  Script saving({new_message("save"), new_message("finish")});
  follow(saving, recorder);
  std::vector<Message> requests = {new_message("finish")};
  if (rank() == 0) {
    Message load = new_message("load");
    put(load, read_state(saving.answers.front()));
    EXPECT_EQ(load.reals("real:part", {2 * size()}).back(), size() - 1);
    requests.insert(requests.begin(), load);
  }
  recorder.part = {0, 0};
  Script loading(requests);
  follow(loading, recorder);
  EXPECT_EQ(recorder.part, part);
}

/// The first rank gets the states of all, the others what is equal on the ranks: from one rank to
/// all, and from all to one.
TEST(RankedSolver, states_of_another_number_of_ranks_are_joined) {
  class Joining : public Recorder {
   public:
    std::vector<State> states;
    State first;
    bool joins_states() const override { return true; }
    void join_states(const State& its_first, std::span<const State> given) override {
      first = its_first;
      states.assign(given.begin(), given.end());
    }
  } joining;
  const State own = Recorder().save_state();
  const State from_one = gather_state(MPI_COMM_SELF, own), from_all = gather_state(comm(), own);
  if (size() == 1) return;
  load_gathered(comm(), from_one, joining);
  ASSERT_EQ(joining.states.size(), rank() == 0 ? 1u : 0u);
  EXPECT_EQ(joining.first.reals.at("part"), (std::vector<double>{1.0 / 3, 0}));
  if (rank() == 0) {
    load_gathered(MPI_COMM_SELF, from_all, joining);
    ASSERT_EQ(joining.states.size(), static_cast<std::size_t>(size()));
    EXPECT_EQ(joining.states.back().reals.at("part"), (std::vector<double>{1.0 / 3, size() - 1.0}));
  }
  Recorder recorder;
  expect_error<ConfigError>([&] { load_gathered(comm(), from_one, recorder); },
                            {"found " + std::to_string(size()) + " MPI ranks, allowed: 1"});
}

/// A folder for all ranks.
class SharedFolder {
 public:
  SharedFolder() {
    if (rank() == 0) std::filesystem::remove_all(path_);
    if (rank() == 0) std::filesystem::create_directories(path_);
    MPI_Barrier(comm());
  }
  ~SharedFolder() {
    MPI_Barrier(comm());
    if (rank() == 0) std::filesystem::remove_all(path_);
  }
  std::string file(const std::string& name) const { return path_ / name; }

 private:
  std::filesystem::path path_ = testing::TempDir() + "gabion_ranked_solver";
};

/// The coupler names a file: each rank writes there, and the answer has no arrays.
TEST(RankedSolver, every_rank_gets_its_part_of_a_file_back) {
  const SharedFolder folder;
  const std::string path = folder.file("soil.h5");
  Recorder recorder;
  const std::vector<double> part = recorder.part;
  Script saving({new_message("save", {{"file", path}}), new_message("finish")});
  follow(saving, recorder);
  Message load = new_message("load");
  if (rank() == 0) {
    const Message& saved = saving.answers.front();
    EXPECT_TRUE(saved.arrays.empty());
    EXPECT_EQ(saved.text("file"), path);
    EXPECT_EQ(saved.integer("file_bytes"),
              static_cast<std::int64_t>(std::filesystem::file_size(path)));
    put(load, read_state(saved));
    EXPECT_EQ(load.text("file"), path);
  }
  recorder.part = {0, 0};
  Script loading({load, new_message("finish")});
  follow(loading, recorder);
  EXPECT_EQ(recorder.part, part);
  // The file holds what the arrays would have held.
  const State all = gather_state(comm(), Recorder().save_state());
  if (rank() == 0) {
    const Hdf5Reader file(path);
    EXPECT_EQ(file.reals("reals/part"), all.reals.at("part"));
    EXPECT_EQ(Json::parse(file.text("facts")), all.facts);
  }
}

TEST(RankedSolver, a_folder_that_is_not_seen_gets_no_file) {
  Recorder recorder;
  RankedSolver solver(comm(), recorder);
  const State state = solver.save_state_to("/no/such/folder/soil.h5");
  EXPECT_TRUE(state.file.empty());
  if (rank() == 0) {
    EXPECT_EQ(state.reals.at("part").size(), 2u * size());
  }
}

TEST(RankedSolver, a_damaged_file_is_refused_on_all_ranks) {
  const SharedFolder folder;
  const std::string path = folder.file("soil.h5");
  Recorder recorder;
  RankedSolver solver(comm(), recorder);
  State state;
  state.file = path;
  int num_ranks = 0;
  MPI_Comm_size(comm(), &num_ranks);
  const auto load = [&] { solver.load_state(state); };
  const std::vector<std::string_view> words = {path, "cannot open this HDF5 file"};
  if (num_ranks == 1) {
    expect_error<ConfigError>(load, words);
  } else {
    expect_error<Error>(load, words);  // on which the ranks agree
  }
  solver.save_state_to(path);
  if (rank() == 0) {
    State other = gather_state(MPI_COMM_SELF, recorder.save_state());
    other.reals["part"].pop_back();
    write_state(path, other);
  }
  MPI_Barrier(comm());
  expect_error<Error>([&] { solver.load_state(state); },
                      {"saved state: \"part\" has 1 values, its ranks had 2"});
}

TEST(RankedSolver, a_lost_coupler_releases_the_others) {
  Recorder recorder;
  Script script({new_message("reject_step")});
  expect_failure(script, recorder, "coupler lost");
  EXPECT_EQ(recorder.calls, std::vector<std::string>{"reject"});
}

TEST(RankedSolver, an_answer_that_cannot_be_sent_releases_the_others) {
  Recorder recorder;
  Script script({new_message("reject_step")});
  script.unsendable = "rejected";
  expect_failure(script, recorder, "queue is full");
}

/// The others have left by then.
TEST(RankedSolver, a_last_answer_that_cannot_be_sent_is_the_first_ranks_alone) {
  Recorder recorder;
  Script script({new_message("finish")});
  script.unsendable = "finished";
  if (rank() == 0) {
    expect_error<ProtocolError>([&] { follow(script, recorder); }, {"queue is full"});
  } else {
    follow(script, recorder);
  }
}

TEST(RankedSolver, kinds_of_forces_reach_all_ranks) {
  Recorder inner;
  Script script({to_message(ForceKinds{{"wall", ForceKind::step_mean}}), new_message("finish")});
  follow(script, inner);
  EXPECT_EQ(inner.calls, std::vector<std::string>{"mean forces"});
  if (rank() == 0) {
    EXPECT_EQ(types_of(script.answers).at(0), "force_kinds_set");
  }
  inner.failing_rank = 0;
  RankedSolver solver(comm(), inner);
  expect_error<Error>(
      [&] {
        solver.set_force_kinds({{"wall", ForceKind::step_mean}});
      },
      {"no mean forces here"});
}

/// Each call ends with the agreement on whether it failed.
TEST(RankedSolver, the_summary_says_what_the_steps_sent) {
  Recorder recorder;
  RankedSolver solver(comm(), recorder);
  InterfaceValues sent;
  solver.probes();  // not a step
  for (int k = 0; k < 3; ++k) solver.solve_step(step, values, sent);
  solver.accept_step(step, true);
  const Json summary = solver.summary();
  EXPECT_GT(summary.at("peak_memory").at("largest_rank"), 1e6);
  const auto seconds = summary.at("cpu_seconds").at("largest_rank").get<double>();
  EXPECT_GT(seconds, 0);
  EXPECT_GE(summary.at("cpu_seconds").at("all_ranks").get<double>(), seconds);
  const auto output = summary.at("output_cpu_seconds").at("all_ranks").get<double>();
  EXPECT_GE(output, 0);
  EXPECT_LE(output, summary.at("cpu_seconds").at("all_ranks").get<double>());
  EXPECT_EQ(summary.contains("mpi"), size() > 1);
  if (size() == 1) return;
  const Json& mpi = summary.at("mpi");
  EXPECT_EQ(mpi.at("collectives"), (Json{{"largest_rank", 4}, {"all_ranks", 4 * size()}}));
  EXPECT_EQ(mpi.at("collective_bytes"), (Json{{"largest_rank", 32}, {"all_ranks", 32 * size()}}));
  EXPECT_EQ(mpi.at("messages").at("all_ranks"), 0);
}

/// The first rank ends the others where, for example, the handshake failed.
TEST(RankedSolver, the_first_rank_can_end_the_others_before_the_first_request) {
  Recorder recorder;
  if (rank() == 0) {
    end_followers(comm(), "refused");
  } else {
    Script none({});
    expect_error<ProtocolError>([&] { follow(none, recorder); }, {"rank 0 failed: refused"});
  }
}

TEST(RankedSolver, a_request_that_is_not_allowed_ends_all_ranks_with_the_same_words) {
  Recorder recorder;
  Script script({accept_request()});
  expect_error<ProtocolError>([&] { follow(script, recorder); },
                              {"accepts step 1, which has no solution"});
}

}  // namespace
}  // namespace gabion::test::test_ranked_solver
