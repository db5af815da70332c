// SPDX-License-Identifier: BSD-3-Clause
// Two ends of a wire on one machine: what goes past the network, and what does not.
#include <gtest/gtest.h>
#include <unistd.h>

#include <future>
#include <map>
#include <string>
#include <thread>

#include "protocol/channel/local_channel.hpp"
#include "protocol/channel/socket.hpp"

namespace gabion::test::test_local_channel {
namespace {

constexpr int patience = 60000;  // [ms]
constexpr std::size_t max_frames = 300;

/// A name that no other test has.
std::string endpoint_of_test() {
  const auto* test = ::testing::UnitTest::GetInstance()->current_test_info();
  return std::string("test ") + test->name() + " " + std::to_string(getpid());
}

/// The next message; waits for it.
RawMessage next(LocalListener& listener) {
  for (;;) {
    if (auto message = listener.take()) return *message;
    std::this_thread::yield();
  }
}

RawMessage next(LocalConnection& connection) {
  for (;;) {
    if (auto message = connection.take()) return *message;
    std::this_thread::yield();
  }
}

TEST(LocalChannel, frames_come_as_they_were_sent_and_answers_find_their_route) {
  auto listener = LocalListener::listen(endpoint_of_test(), max_frames);
  ASSERT_TRUE(listener);
  auto one = LocalConnection::connect(endpoint_of_test(), max_frames);
  auto two = LocalConnection::connect(endpoint_of_test(), max_frames);
  ASSERT_TRUE(one && two);
  one->send({"one"});
  two->send({"two"});
  const std::string zeros(3, '\0');
  one->send({"header", "", zeros});
  two->send({"other"});
  std::map<std::string, RawMessage> came;
  for (int k = 0; k < 2; ++k) {
    const RawMessage message = next(*listener);
    came[message.at(0)] = message;
  }
  EXPECT_EQ(came.at("one"), (RawMessage{"one", "header", "", zeros}));
  EXPECT_EQ(came.at("two"), (RawMessage{"two", "other"}));
  EXPECT_TRUE(listener->has("one"));
  EXPECT_FALSE(listener->has("three"));
  EXPECT_TRUE(listener->send({"two", "answer"}));
  EXPECT_EQ(next(*two), RawMessage{"answer"});
  EXPECT_FALSE(one->take());
  EXPECT_FALSE(listener->send({"three", "answer"}));
}

TEST(LocalChannel, long_messages_cross_without_either_end_waiting) {
  auto listener = LocalListener::listen(endpoint_of_test(), max_frames);
  auto connection = LocalConnection::connect(endpoint_of_test(), max_frames);
  ASSERT_TRUE(listener && connection);
  connection->send({"route"});
  connection->send({"here"});
  next(*listener);
  std::string there(5'000'000, 'a'), back(7'000'000, 'b');
  there.back() = back.back() = 'z';
  EXPECT_TRUE(listener->send({"route", "header", there}));  // nobody reads
  EXPECT_TRUE(connection->send({back, "last"}));
  EXPECT_TRUE(listener->has_unsent());
  EXPECT_TRUE(connection->has_unsent());
  auto other_end = std::async(std::launch::async, [&] {
    while (connection->has_unsent()) connection->flush();
    return next(*connection);
  });
  std::optional<RawMessage> came;
  while (!came || listener->has_unsent()) {
    listener->flush();
    if (!came) came = listener->take();
    std::this_thread::yield();
  }
  EXPECT_EQ(*came, (RawMessage{"route", back, "last"}));
  EXPECT_EQ(other_end.get(), (RawMessage{"header", there}));
}

TEST(LocalChannel, what_a_peer_said_before_it_went_is_heard) {
  auto listener = LocalListener::listen(endpoint_of_test(), max_frames);
  ASSERT_TRUE(listener);
  {
    auto connection = LocalConnection::connect(endpoint_of_test(), max_frames);
    ASSERT_TRUE(connection);
    connection->send({"route"});
    connection->send({"hello"});
    EXPECT_EQ(next(*listener), (RawMessage{"route", "hello"}));
    connection->send({"last words"});
  }
  EXPECT_FALSE(listener->send({"route", "too late"}));
  EXPECT_EQ(next(*listener), (RawMessage{"route", "last words"}));
  EXPECT_FALSE(listener->take());
  EXPECT_FALSE(listener->has("route"));
  EXPECT_FALSE(listener->send({"route", "too late"}));
}

TEST(LocalChannel, a_peer_that_is_not_understood_is_let_go) {
  auto listener = LocalListener::listen(endpoint_of_test(), 2);
  auto connection = LocalConnection::connect(endpoint_of_test(), max_frames);
  ASSERT_TRUE(listener && connection);
  connection->send({"route"});
  connection->send({"more", "frames", "than", "allowed"});
  while (connection->send({"any"})) listener->take();
  EXPECT_FALSE(listener->has("route"));
  EXPECT_FALSE(connection->takes_messages());
}

TEST(LocalChannel, is_there_for_the_endpoint_of_a_coupler_only) {
  EXPECT_FALSE(LocalConnection::connect(endpoint_of_test(), max_frames));
  auto listener = LocalListener::listen(endpoint_of_test(), max_frames);
  ASSERT_TRUE(listener);
  EXPECT_FALSE(LocalListener::listen(endpoint_of_test(), max_frames));
  EXPECT_FALSE(LocalConnection::connect(endpoint_of_test() + " other", max_frames));
  EXPECT_FALSE(LocalListener::listen(std::string(200, 'x'), max_frames));
}

/// A message over two sockets, and its answer. @returns the route that the coupler saw
std::string exchange(Socket& coupler, Socket& participant) {
  EXPECT_TRUE(participant.send({"hello", "values"}));
  const auto came = coupler.receive(patience);
  if (!came) return "nothing came";
  EXPECT_EQ((RawMessage{came->begin() + 1, came->end()}), (RawMessage{"hello", "values"}));
  EXPECT_TRUE(coupler.send({came->at(0), "welcome"}));
  EXPECT_EQ(participant.receive(patience), (RawMessage{"welcome"}));
  return came->at(0);
}

TEST(LocalChannel, sockets_of_one_machine_use_it) {
  const auto context = make_socket_context();
  Socket coupler = Socket::bind_router(context, "tcp://127.0.0.1:*");
  Socket participant = Socket::connect_dealer(context, coupler.endpoint(), "soil#1");
  EXPECT_EQ(exchange(coupler, participant), "soil#1");
  EXPECT_TRUE(coupler.is_local("soil#1"));
  EXPECT_FALSE(coupler.is_local("structure#1"));
}

TEST(LocalChannel, an_answer_goes_out_whole_before_the_next_request_is_taken) {
  const auto context = make_socket_context();
  Socket coupler = Socket::bind_router(context, "tcp://127.0.0.1:*");
  Socket participant = Socket::connect_dealer(context, coupler.endpoint(), "soil#1");
  exchange(coupler, participant);
  const std::string answer(5'000'000, 'a');
  EXPECT_TRUE(participant.send({answer}));
  EXPECT_TRUE(coupler.send({"soil#1", "next"}));
  EXPECT_FALSE(participant.receive(1));
  auto other_end = std::async(std::launch::async, [&] { return participant.receive(patience); });
  EXPECT_EQ(coupler.receive(patience), (RawMessage{"soil#1", answer}));
  EXPECT_EQ(other_end.get(), (RawMessage{"next"}));
}

TEST(LocalChannel, a_participant_that_calls_the_coupler_otherwise_goes_over_the_network) {
  const auto context = make_socket_context();
  Socket coupler = Socket::bind_router(context, "tcp://127.0.0.1:*");
  std::string endpoint = coupler.endpoint();
  endpoint.replace(endpoint.find("127.0.0.1"), 9, "localhost");
  Socket participant = Socket::connect_dealer(context, endpoint, "soil#1");
  EXPECT_EQ(exchange(coupler, participant), "soil#1");
  EXPECT_FALSE(coupler.is_local("soil#1"));
}

}  // namespace
}  // namespace gabion::test::test_local_channel
