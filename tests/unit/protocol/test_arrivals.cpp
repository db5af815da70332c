// SPDX-License-Identifier: BSD-3-Clause
// Who comes to the coupler's socket: participants while signs of life go around, and strangers.
#include <gtest/gtest.h>

#include <atomic>
#include <future>
#include <list>
#include <thread>

#include "dummy_solver.hpp"
#include "protocol/serve.hpp"
#include "raw_participant.hpp"

namespace gabion::test::test_arrivals {
namespace {

/// A coupler's socket, and what a participant's handshake with it ends with.
class AtBoard {
 public:
  AtBoard()
      : end_(std::async(std::launch::async, [endpoint = board.endpoint()] {
          return message_of<Error>([&] {
            DummySolver solver(3, 2, 1.0);
            Connection connection(participant("soil", endpoint));
            connection.handshake(solver);
          });
        })) {}
  std::string hello() {
    for (;;) {
      if (const auto arrival = board.next_arrival()) return arrival->route;
    }
  }
  std::string end() { return end_.get(); }

  Switchboard board{"tcp://127.0.0.1:*", patient_settings().deadlines};

 private:
  std::future<std::string> end_;
};

TEST(Arrivals, signs_of_life_may_come_before_the_welcome) {
  AtBoard at;
  const std::string route = at.hello();
  const Message alive = new_message("alive", {{"phase", "handshake"}, {"seconds", 0.0}});
  Welcome welcome;
  welcome.deadlines = patient_settings().deadlines;
  for (int k = 0; k < 3; ++k) at.board.answer(route, alive);
  at.board.answer(route, to_message(welcome));
  EXPECT_EQ(at.end(), "");
}

/// Signs of life as often as a thread can give them.
TEST(Arrivals, none_goes_to_a_participant_before_its_welcome) {
  ServerSettings settings = patient_settings();
  settings.deadlines.heartbeat = 1e-6;
  Server server(settings);
  std::vector<Expected> all;
  std::list<RawParticipant> raw;
  for (int k = 0; k < 40; ++k) {
    const std::string name = "structure" + std::to_string(k);
    all.push_back(expected(name));
    Hello hello = good_hello(name);
    hello.sends_heartbeat = true;
    raw.emplace_back(server.endpoint(), name).send(to_message(hello));
  }
  EXPECT_EQ(server.wait_for(all).size(), raw.size());
  for (RawParticipant& each : raw) EXPECT_EQ(each.receive_any().type, "welcome");
}

TEST(Arrivals, endpoints_of_ipv6_are_understood) {
  ServerSettings settings = patient_settings();
  settings.endpoint = "tcp://[::1]:*";
  // The second one names the machine in other words, so that messages go over the network.
  for (const std::string host : {"tcp://[::1]", "tcp://[0::1]"}) {
    std::unique_ptr<Server> server;
    try {
      server = std::make_unique<Server>(settings);
    } catch (const ConfigError& problem) {
      const std::string why = problem.what();
      if (why.find("Cannot assign requested address") == std::string::npos) throw;
      GTEST_SKIP() << "no IPv6 on this machine: " << why;
    }
    const std::string endpoint = server->endpoint();
    EXPECT_TRUE(endpoint.starts_with("tcp://[::1]:")) << endpoint;
    RawParticipant raw(host + endpoint.substr(endpoint.rfind(':')), "raw");
    raw.send(to_message(good_hello("soil")));
    EXPECT_EQ(server->wait_for({expected("soil")}).size(), 1u);
  }
}

TEST(Arrivals, a_port_that_is_taken_is_a_wrong_setting) {
  Server first(patient_settings());
  ServerSettings settings = patient_settings();
  settings.endpoint = first.endpoint();
  const std::string error = message_of<ConfigError>([&] { Server second(settings); });
  EXPECT_NE(error.find("cannot listen on \"" + first.endpoint()), std::string::npos) << error;
  EXPECT_NE(error.find("Address already in use"), std::string::npos) << error;
}

TEST(Arrivals, garbage_from_strangers_is_ignored) {
  Server server(patient_settings());
  RawParticipant stranger(server.endpoint(), "stranger");
  stranger.send_frames({"GET / HTTP/1.1"});
  stranger.send_frames({"", ""});
  stranger.send_frames({R"({"type":"solved","sequence":1})"});
  stranger.send_frames({R"({"type":"alive","sequence":1})"});
  RawParticipant raw(server.endpoint(), "raw");
  raw.send(to_message(good_hello("soil")));
  EXPECT_EQ(server.wait_for({expected("soil")}).size(), 1u);
}

/// Sends messages that are none of the protocol until it ends, and reads no answer.
class Flood {
 public:
  explicit Flood(const std::string& endpoint)
      : thread_([this, endpoint] {
          // Another name of the endpoint leads over the network, where a queue that is full blocks.
          const std::string remote = "tcp://localhost" + endpoint.substr(endpoint.rfind(':'));
          RawParticipant stranger(remote, "flood");
          while (!stopping_) {
            for (int k = 0; k < 1000; ++k) stranger.send_frames({"x"});
            sent_ += 1000;
          }
        }) {}
  ~Flood() {
    stopping_ = true;
    thread_.join();
  }
  Flood(const Flood&) = delete;
  Flood& operator=(const Flood&) = delete;
  std::int64_t sent() const { return sent_; }

 private:
  std::atomic<bool> stopping_ = false;
  std::atomic<std::int64_t> sent_ = 0;
  std::thread thread_;
};

/// Many more than the queues of both sides hold: the coupler reads them on, and answers one.
TEST(Arrivals, a_stranger_that_never_reads_holds_up_nobody) {
  Server server(patient_settings());
  const Flood flood(server.endpoint());
  while (flood.sent() < 5000) std::this_thread::yield();
  DummySolver soil(3, 2, 1.0);
  auto end = serve_aside(soil, participant("soil", server.endpoint()));
  auto solvers = server.wait_for({expected("soil")});
  InterfaceValues sent;
  for (int step = 1; step <= 20 || flood.sent() < 100000; ++step) {
    solvers.at("soil")->solve_step({step, 0, 0.1 * (step - 1), 0.1}, {}, sent);
    solvers.at("soil")->accept_step({step, 0, 0.1 * (step - 1), 0.1}, true);
  }
  server.finish();
  EXPECT_EQ(end.get(), "");
}

TEST(Arrivals, who_was_refused_is_not_heard_again) {
  Switchboard board("tcp://127.0.0.1:*", patient_settings().deadlines);
  RawParticipant stranger(board.endpoint(), "stranger");
  stranger.send_frames({"x"});
  for (int k = 0; k < 3; ++k) stranger.send(to_message(good_hello("soil")));
  RawParticipant other(board.endpoint(), "other");
  other.send_frames({"x"});
  other.send(to_message(good_hello("soil")));
  RawParticipant good(board.endpoint(), "good");
  good.send(to_message(good_hello("soil")));
  std::optional<Switchboard::Arrival> arrival;
  while (!arrival) arrival = board.next_arrival();
  EXPECT_EQ(arrival->route, "good");
  EXPECT_EQ(stranger.receive().type, "refused");
  EXPECT_EQ(other.receive().type, "refused");
  EXPECT_EQ(stranger.receive(100).type, "");
}

TEST(Arrivals, a_wait_ends_at_its_deadline_however_many_come) {
  ServerSettings settings = patient_settings();
  settings.deadlines.connect = 0.3;
  Server server(settings);
  std::atomic<bool> stopping = false;
  std::thread stranger([&, endpoint = server.endpoint()] {
    const Message hello = new_message("hello");
    for (int k = 0; !stopping; ++k) {
      RawParticipant(endpoint, "stranger" + std::to_string(k)).send(hello);
    }
  });
  const std::string error = message_of<ProtocolError>([&] { server.wait_for({expected("soil")}); });
  stopping = true;
  stranger.join();
  EXPECT_NE(error.find("protocol/connect_deadline"), std::string::npos) << error;
}

}  // namespace
}  // namespace gabion::test::test_arrivals
