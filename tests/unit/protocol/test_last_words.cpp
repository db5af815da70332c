// SPDX-License-Identifier: BSD-3-Clause
// Messages that have come count before a death: the peer is known to be gone while its words are
// still to be read.
#include <gtest/gtest.h>

#include <csignal>
#include <future>

#include "common/base/interrupt.hpp"
#include "dummy_solver.hpp"
#include "protocol/serve.hpp"
#include "protocol/wire/exchange.hpp"
#include "raw_participant.hpp"
#include "tests/support/expect_error.hpp"

namespace gabion::test::test_last_words {
namespace {

/// A process of this machine that has ended: its number was given away again.
ProcessIdentity gone() {
  ProcessIdentity process = this_process();
  process.start_time += 1;
  return process;
}

Message solved(const std::string& quantity) {
  Message reply = new_message("solved", {{"busy_seconds", 0.0}});
  put(reply, StepReport{});
  reply.add(quantity + ":wall", {3, 2}, std::vector<double>(6, 1.0));
  return reply;
}

Message accepted() {
  Message reply = new_message("accepted", {{"busy_seconds", 0.0}});
  put(reply, AcceptReport{});
  return reply;
}

Message busy(Message reply) {
  reply.fields["busy_seconds"] = 0.0;
  return reply;
}

/// A participant whose process is gone when the coupler first looks. It is asked once; its answer
/// comes only when the coupler, which has found no process, looks whether the connection is closed.
class GoneParticipant {
 public:
  /// @param last  said instead of an answer when its type is "abort"; empty type: nothing
  GoneParticipant(const std::string& endpoint, const std::string& name, Message last)
      : end_(std::async(std::launch::async, [endpoint, name, last] {
          RawParticipant raw(endpoint, name);
          Hello hello = good_hello(name);
          hello.process = gone();
          hello.keeps_state = true;
          raw.send(to_message(hello));
          raw.receive();
          Message words = last;
          words.sequence = raw.receive().sequence;
          while (raw.receive_any().type != "alive") {
          }
          if (words.type == "finished") std::raise(SIGTERM);
          if (!words.type.empty()) raw.send(words);
        })) {}

 private:
  std::future<void> end_;
};

/// A signal that came is forgotten at the end.
class LastWords : public testing::Test {
 protected:
  void SetUp() override { interrupt::install(); }
  void TearDown() override {
    solvers_.clear();
    server_.reset();
    interrupt::clear();
    std::signal(SIGTERM, SIG_DFL);
    std::signal(SIGINT, SIG_DFL);
  }

  RemoteSolver& connect(const Message& last) {
    server_ = std::make_unique<Server>(patient_settings());
    soil_ = std::make_unique<GoneParticipant>(server_->endpoint(), "soil", last);
    solvers_ = server_->wait_for({expected("soil")});
    return static_cast<RemoteSolver&>(*solvers_.at("soil"));
  }
  /// The answer that came is taken; the next question finds the death.
  template <class Call>
  void expect_answered_then_dead(const Message& answer, const Call& call) {
    RemoteSolver& soil = connect(answer);
    EXPECT_NO_THROW(call(soil)) << answer.type;
    expect_error<ProtocolError>([&] { soil.reject_step(); },
                                {"participant \"soil\" (foreign, pid ", ") has died: no process"});
  }

  std::unique_ptr<Server> server_;
  std::unique_ptr<GoneParticipant> soil_, structure_;
  std::map<std::string, std::unique_ptr<Solver>> solvers_;
  const StepRequest step_{1, 0, 0, 0.1};
};

/// Even when the launcher, which sees processes end, sends its signal in the meantime.
TEST_F(LastWords, a_completed_run_is_no_failure) {
  server_ = std::make_unique<Server>(patient_settings());
  soil_ =
      std::make_unique<GoneParticipant>(server_->endpoint(), "soil", busy(new_message("finished")));
  solvers_ = server_->wait_for({expected("soil")});
  EXPECT_NO_THROW(server_->finish());
}

TEST_F(LastWords, a_solution_counts) {
  InterfaceValues sent;
  expect_answered_then_dead(solved("force"),
                            [&](RemoteSolver& soil) { soil.solve_step(step_, {}, sent); });
  EXPECT_EQ(sent["wall"], std::vector<double>(6, 1.0));
}

TEST_F(LastWords, an_accepted_step_counts) {
  expect_answered_then_dead(accepted(), [&](RemoteSolver& soil) { soil.accept_step(step_, true); });
}

TEST_F(LastWords, output_that_was_written_counts) {
  expect_answered_then_dead(busy(new_message("written")),
                            [](RemoteSolver& soil) { soil.write_output(0.1); });
}

TEST_F(LastWords, a_state_that_was_saved_counts) {
  State state;
  state.reals["u"] = {1.0 / 3};
  State found;
  expect_answered_then_dead(busy(saved(state)),
                            [&](RemoteSolver& soil) { found = soil.save_state(); });
  EXPECT_EQ(found.reals, state.reals);
}

/// A file is missing where the participant wrote it on another machine.
TEST_F(LastWords, a_file_that_is_not_there_is_an_error) {
  Message answer = busy(new_message("saved", {{"state", Json::object()}}));
  answer.fields["file"] = "/no/such/folder/soil.h5";
  answer.fields["file_bytes"] = 17;
  RemoteSolver& soil = connect(answer);
  expect_error<ProtocolError>([&] { soil.save_state_to("/no/such/folder/soil.h5"); },
                              {"participant \"soil\" says that it wrote 17 bytes to "
                               "/no/such/folder/soil.h5: found No such file or directory"});
}

TEST_F(LastWords, a_reason_is_the_better_message) {
  RemoteSolver& soil = connect(new_message("abort", {{"reason", "disk full"}}));
  expect_error<ProtocolError>([&] { soil.reject_step(); },
                              {"participant \"soil\" (foreign, pid ", "ended the run: disk full"});
}

TEST_F(LastWords, who_says_nothing_has_died) {
  RemoteSolver& soil = connect({});
  expect_error<ProtocolError>([&] { soil.reject_step(); }, {") has died: no process"});
}

/// Nobody waits for the one that is gone.
TEST_F(LastWords, the_death_of_another_one_is_told_with_its_reason) {
  server_ = std::make_unique<Server>(patient_settings());
  soil_ = std::make_unique<GoneParticipant>(server_->endpoint(), "soil",
                                            new_message("abort", {{"reason", "disk full"}}));
  RawParticipant structure(server_->endpoint(), "structure");
  structure.send(to_message(good_hello("structure")));
  solvers_ = server_->wait_for({expected("soil"), expected("structure")});
  static_cast<RemoteSolver&>(*solvers_.at("soil")).start_solve(step_, {});
  expect_error<ProtocolError>([&] { solvers_.at("structure")->reject_step(); },
                              {"participant \"soil\"", "ended the run: disk full"});
}

/// The connection is closed before the coupler asks.
TEST_F(LastWords, a_reason_before_the_question_is_told) {
  server_ = std::make_unique<Server>(patient_settings());
  auto raw = std::make_unique<RawParticipant>(server_->endpoint(), "soil");
  raw->send(to_message(good_hello("soil")));
  solvers_ = server_->wait_for({expected("soil")});
  raw->send(new_message("abort", {{"reason", "disk full"}}));
  raw.reset();
  expect_error<ProtocolError>([&] { solvers_.at("soil")->reject_step(); },
                              {"participant \"soil\"", "ended the run: disk full"});
}

/// A coupler that says all it has to say at once, and a participant in this thread.
class GoneCoupler {
 public:
  GoneCoupler(const ProcessIdentity& process, const std::vector<Message>& last)
      : socket_(Socket::bind_router(make_socket_context(), "tcp://127.0.0.1:*")),
        endpoint_(socket_.endpoint()),
        talk_(std::async(std::launch::async, [this, process, last] { talk(process, last); })) {}

  const std::string& endpoint() const { return endpoint_; }
  /// The participant's last message that is no sign of life.
  Message last_answer() {
    talk_.wait();
    return receive();
  }

 private:
  void talk(const ProcessIdentity& process, const std::vector<Message>& last) {
    receive();
    Welcome welcome;
    welcome.process = process;
    send(to_message(welcome));
    send(new_message("alive", {{"phase", "finish"}, {"seconds", 0.0}}));
    for (const Message& message : last) send(message);
  }
  Message receive() {
    for (int i = 0; i < 500; ++i) {
      auto frames = socket_.receive(100);
      if (!frames) continue;
      Message message = decode(std::span<const std::string>(*frames).subspan(1));
      if (message.type == "alive") continue;
      route_ = frames->front();
      return message;
    }
    return {};
  }
  void send(const Message& message) {
    const EncodedMessage encoded = encode(message);
    std::vector<std::string_view> frames = {route_, encoded.header};
    frames.insert(frames.end(), encoded.payloads.begin(), encoded.payloads.end());
    socket_.send(frames);
  }

  Socket socket_;
  std::string endpoint_;
  std::string route_;
  std::future<void> talk_;
};

/// Serve a coupler until the run ends. The sign of life before its last words makes the participant
/// look whether the coupler lives, while they stand in the queue.
void serve_gone(GoneCoupler& coupler) {
  DummySolver solver(3, 2, 1.0);
  Connection connection(participant("soil", coupler.endpoint()));
  connection.handshake(solver);
  std::this_thread::sleep_for(std::chrono::milliseconds(60));  // looks are 50 ms apart at least
  serve(solver, connection);
}

Message request(const std::string& type, Json fields = Json::object()) {
  Message message = new_message(type, std::move(fields));
  message.sequence = 1;
  return message;
}

TEST_F(LastWords, a_participant_that_is_told_to_finish_ends_well) {
  GoneCoupler coupler(gone(), {request("finish")});
  EXPECT_NO_THROW(serve_gone(coupler));
  EXPECT_EQ(coupler.last_answer().type, "finished");
}

TEST_F(LastWords, a_participant_that_is_told_to_finish_ends_well_when_a_signal_comes_too) {
  GoneCoupler coupler(this_process(), {request("finish")});
  DummySolver solver(3, 2, 1.0);
  Connection connection(participant("soil", coupler.endpoint()));
  connection.handshake(solver);
  std::raise(SIGTERM);
  EXPECT_NO_THROW(serve(solver, connection));
  EXPECT_EQ(coupler.last_answer().type, "finished");
}

TEST_F(LastWords, a_participant_is_told_why_the_coupler_ended) {
  GoneCoupler coupler(gone(), {request("abort", {{"reason", "dt_min reached"}})});
  expect_error<NeverBegun>([&] { serve_gone(coupler); },
                           {"the coupler ended the run: dt_min reached"});
}

TEST_F(LastWords, what_else_a_coupler_asked_that_is_gone_nobody_awaits) {
  GoneCoupler coupler(gone(), {request("summarize")});
  expect_error<ProtocolError>([&] { serve_gone(coupler); }, {"the coupler (pid ", ") has died"});
}

}  // namespace
}  // namespace gabion::test::test_last_words
