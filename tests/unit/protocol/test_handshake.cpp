// SPDX-License-Identifier: BSD-3-Clause
// Every kind of disagreement is refused, and both sides are told both values.
#include <gtest/gtest.h>

#include <cmath>
#include <future>

#include "dummy_solver.hpp"
#include "protocol/serve.hpp"
#include "protocol/wire/force_kinds.hpp"
#include "raw_participant.hpp"

namespace gabion::test::test_handshake {
namespace {

struct Outcome {
  std::string coupler;      // text of the coupler's error
  std::string participant;  // reason in "refused"
};

/// The coupler's reaction to this first message of a participant.
Outcome outcome_of(const Message& hello, const std::vector<Expected>& participants) {
  Server server(patient_settings());
  RawParticipant raw(server.endpoint(), "raw");
  raw.send(hello);
  Outcome outcome;
  outcome.coupler = message_of<ProtocolError>([&] { server.wait_for(participants); });
  const Message answer = raw.receive();
  EXPECT_EQ(answer.type, "refused");
  if (answer.type == "refused") outcome.participant = answer.text("reason");
  return outcome;
}

void expect_refused(const Message& hello, const std::vector<std::string>& parts) {
  const Outcome outcome = outcome_of(hello, {expected("soil")});
  for (const std::string& part : parts) {
    EXPECT_NE(outcome.coupler.find(part), std::string::npos) << part << "\n" << outcome.coupler;
    EXPECT_NE(outcome.participant.find(part), std::string::npos) << part << "\n"
                                                                 << outcome.participant;
  }
}

/// The sender of a hello that is not complete is told why; the coupler waits on, and another one
/// may come.
void expect_turned_down(const Message& hello, const std::vector<std::string>& parts) {
  Server server(patient_settings());
  RawParticipant raw(server.endpoint(), "raw");
  raw.send(hello);
  auto arrived =
      std::async(std::launch::async, [&] { return server.wait_for({expected("soil")}).size(); });
  const Message answer = raw.receive();
  RawParticipant good(server.endpoint(), "good");
  good.send(to_message(good_hello("soil")));
  EXPECT_EQ(arrived.get(), 1u);
  ASSERT_EQ(answer.type, "refused");
  for (const std::string& part : parts) {
    EXPECT_NE(answer.text("reason").find(part), std::string::npos) << part << "\n"
                                                                   << answer.text("reason");
  }
}

TEST(Handshake, messages_round_trip) {
  Hello hello = good_hello("soil");
  hello.probe_names = {"tip"};
  hello.probes = {0.25};
  hello.process = this_process();
  const Hello back = read_hello(to_message(hello));
  EXPECT_EQ(back.participant, hello.participant);
  EXPECT_EQ(back.session, hello.session);
  EXPECT_EQ(back.receives, hello.receives);
  EXPECT_EQ(back.sends, hello.sends);
  EXPECT_EQ(back.interfaces.at(0).coordinates, hello.interfaces[0].coordinates);
  EXPECT_EQ(back.interfaces.at(0).facets, hello.interfaces[0].facets);
  EXPECT_EQ(back.probes, hello.probes);
  EXPECT_EQ(back.process.host, hello.process.host);
  EXPECT_EQ(back.process.start_time, hello.process.start_time);
  EXPECT_FALSE(back.sends_heartbeat);

  Welcome welcome;
  welcome.run = {{"end", 2.5}};
  welcome.deadlines.silence = 3;
  const Welcome welcomed = read_welcome(to_message(welcome));
  EXPECT_EQ(welcomed.run, welcome.run);
  EXPECT_EQ(welcomed.deadlines.silence, 3);
}

TEST(Handshake, taking_the_next_step_early_is_optional) {
  Hello hello = good_hello("soil");
  hello.takes_next_step = true;
  Message message = to_message(hello);
  EXPECT_TRUE(read_hello(message).takes_next_step);
  message.fields.erase("takes_next_step");  // as before 1.3
  EXPECT_FALSE(read_hello(message).takes_next_step);
  message.fields["takes_next_step"] = 1;
  expect_turned_down(message, {"field \"takes_next_step\": expected true or false, found 1"});
}

TEST(Handshake, kinds_of_forces_round_trip_and_are_optional) {
  Hello hello = good_hello("soil");
  hello.takes_force_kinds = true;
  hello.interfaces.at(0).force_kind = ForceKind::step_mean;
  Message message = to_message(hello);
  EXPECT_EQ(message.fields["interfaces"][0]["force_kind"], "step_mean");
  EXPECT_EQ(read_hello(message).interfaces.at(0).force_kind, ForceKind::step_mean);
  EXPECT_TRUE(read_hello(message).takes_force_kinds);
  message.fields.erase("takes_force_kinds");  // as before 1.2
  message.fields["interfaces"][0].erase("force_kind");
  EXPECT_EQ(read_hello(message).interfaces.at(0).force_kind, ForceKind::end_of_step);
  EXPECT_FALSE(read_hello(message).takes_force_kinds);
  message.fields["interfaces"][0]["force_kind"] = "late";
  expect_turned_down(message,
                     {"expected force_kind \"end_of_step\" or \"step_mean\", found \"late\""});
}

TEST(Handshake, a_structure_says_where_it_starts) {
  Hello hello = good_hello("structure");
  const InterfaceMesh& mesh = hello.interfaces.at(0);
  EXPECT_FALSE(to_message(hello).has_array("displacement:wall"));
  EXPECT_TRUE(read_hello(to_message(hello)).start.empty());
  std::vector<double> u(mesh.coordinates.size(), 1.0 / 3);
  u.front() = -2e-300;
  hello.start = {{"wall", u}};
  EXPECT_EQ(read_hello(to_message(hello)).start, hello.start);
  const auto refused = [](const Message& message) {
    return message_of<ProtocolError>([&] { read_hello(message); });
  };
  hello.start["wall"].back() = std::nan("");
  EXPECT_NE(refused(to_message(hello)).find("displacement:wall"), std::string::npos);
  Message message = to_message(good_hello("structure"));
  message.add("displacement:wall", {1, mesh.dim}, std::vector<double>{0, 0});
  EXPECT_NE(refused(message).find("displacement:wall"), std::string::npos);
}

TEST(Handshake, taking_the_start_is_optional) {
  Hello hello = good_hello("soil");
  hello.takes_start = true;
  Message message = to_message(hello);
  EXPECT_TRUE(read_hello(message).takes_start);
  message.fields.erase("takes_start");  // as before 1.4
  EXPECT_FALSE(read_hello(message).takes_start);
  message.fields["takes_start"] = 1;
  expect_turned_down(message, {"field \"takes_start\": expected true or false, found 1"});
}

TEST(Handshake, kinds_of_forces_are_those_of_the_interfaces) {
  const std::vector<InterfaceMesh> meshes = good_hello("structure").interfaces;
  const ForceKinds kinds = {{"wall", ForceKind::step_mean}};
  EXPECT_EQ(read_force_kinds(to_message(kinds), meshes), kinds);
  const auto refused = [&](const Json& value) {
    return message_of<ProtocolError>([&] {
      read_force_kinds(new_message("set_force_kinds", {{"kinds", value}}), meshes);
    });
  };
  EXPECT_NE(refused({{"roof", "step_mean"}}).find("\"roof\" is none of this"), std::string::npos);
  EXPECT_NE(refused({{"wall", 3}}).find("expected force_kind as a text"), std::string::npos);
  EXPECT_NE(refused("wall").find("expected an object"), std::string::npos);
}

TEST(Handshake, other_major_version_is_refused) {
  Hello hello = good_hello("soil");
  hello.protocol = "2.0";
  expect_refused(to_message(hello), {"protocol version", protocol_version, "2.0"});
}

TEST(Handshake, other_minor_version_is_welcome) {
  Server server(patient_settings());
  RawParticipant raw(server.endpoint(), "raw");
  Hello hello = good_hello("soil");
  hello.protocol = "1.7";
  raw.send(to_message(hello));
  EXPECT_EQ(server.wait_for({expected("soil")}).size(), 1u);
  EXPECT_EQ(raw.receive().type, "welcome");
}

TEST(Handshake, foreign_code_without_scene_hash_is_welcome) {
  Server server(patient_settings());
  RawParticipant raw(server.endpoint(), "raw");
  Hello hello = good_hello("soil");
  hello.scene_hash = "";
  raw.send(to_message(hello));
  EXPECT_EQ(server.wait_for({expected("soil")}).size(), 1u);
}

TEST(Handshake, every_mismatch_is_refused_with_both_values) {
  Hello hello = good_hello("soil");
  hello.scene_hash = "def";
  expect_refused(to_message(hello), {"scene hash", "abc", "def"});
  hello = good_hello("soil");
  hello.interfaces[0].name = "dam";
  expect_refused(to_message(hello), {"interfaces", "wall", "dam"});
  hello = good_hello("soil");
  hello.interfaces.clear();
  expect_refused(to_message(hello), {"interfaces", "wall", "{}"});
  hello = good_hello("soil");
  hello.sends.unit = "kN";
  expect_refused(to_message(hello), {"sends", "force [N]", "force [kN]"});
  hello = good_hello("soil");
  hello.receives = force();
  expect_refused(to_message(hello), {"receives", "displacement [m]", "force [N]"});
  hello = good_hello("soil");
  hello.convention = "force: by structure on soil";
  expect_refused(to_message(hello), {"sign convention", sign_convention, hello.convention});
  hello = good_hello("soil");
  hello.dimension = 3;
  hello.interfaces[0].dim = 3;
  hello.interfaces[0].coordinates.resize(9);
  expect_refused(to_message(hello), {"dimension", "2", "3"});
}

TEST(Handshake, all_mismatches_are_told_at_once) {
  Hello hello = good_hello("soil");
  hello.scene_hash = "def";
  hello.sends.unit = "kN";
  expect_refused(to_message(hello), {"scene hash", "the same --set", "kN"});
}

TEST(Handshake, unknown_name_is_refused) {
  expect_refused(to_message(good_hello("structure")), {"participant name", "soil", "structure"});
}

TEST(Handshake, name_twice_is_refused) {
  Server server(patient_settings());
  RawParticipant first(server.endpoint(), "a");
  RawParticipant second(server.endpoint(), "b");
  first.send(to_message(good_hello("soil")));
  second.send(to_message(good_hello("soil")));
  const std::string error = message_of<ProtocolError>([&] {
    server.wait_for({expected("soil"), expected("structure")});
  });
  EXPECT_NE(error.find("\"soil\" is connected already"), std::string::npos) << error;
  const std::string one = first.receive().type;
  const std::string other = second.receive().type;
  EXPECT_EQ((std::set<std::string>{one, other}), (std::set<std::string>{"welcome", "refused"}));
}

TEST(Handshake, hello_during_the_run_is_refused_and_the_run_goes_on) {
  Server server(patient_settings());
  DummySolver soil(3, 2, 1.0);
  auto end = serve_aside(soil, participant("soil", server.endpoint()));
  auto solvers = server.wait_for({expected("soil")});
  RawParticipant late(server.endpoint(), "late");
  late.send(to_message(good_hello("soil")));
  InterfaceValues sent;
  Message answer;
  for (int i = 0; i < 10000 && answer.type.empty(); ++i) {
    solvers.at("soil")->solve_step({1, i, 0, 0.1}, {}, sent);
    answer = late.receive(10);
  }
  EXPECT_EQ(answer.type, "refused");
  solvers.at("soil")->solve_step({1, 0, 0, 0.1}, {}, sent);
  server.finish();
  EXPECT_EQ(end.get(), "");
}

TEST(Handshake, broken_hellos_are_refused) {
  const auto broken = [](const std::string& key, const Json& value) {
    Message hello = to_message(good_hello("soil"));
    hello.fields[key] = value;
    return hello;
  };
  expect_turned_down(broken("participant", "so il"), {"\"participant\""});
  expect_turned_down(broken("participant", std::string(65, 'a')), {"\"participant\""});
  expect_turned_down(broken("dimension", 4), {"dimension 2 or 3", "4"});
  expect_turned_down(broken("sends", "force"), {"\"sends\"", "an object"});
  expect_turned_down(broken("protocol", "one"), {"major.minor", "one"});
  expect_turned_down(broken("probe_names", {1}), {"list of texts"});
  Message bad_facet = to_message(good_hello("soil"));
  std::get<std::vector<std::int64_t>>(bad_facet.arrays.at(1).values)[3] = 3;
  expect_turned_down(bad_facet, {"facet names vertex 3, there are 3"});
  Message bad_coordinate = to_message(good_hello("soil"));
  std::get<std::vector<double>>(bad_coordinate.arrays.at(0).values)[4] = std::nan("");
  expect_turned_down(bad_coordinate, {"coordinates:wall", "vertex 2, component 0"});
}

TEST(Handshake, names_that_are_no_columns_are_refused) {
  const auto with_probes = [](const std::vector<std::string>& names) {
    Hello hello = good_hello("soil");
    hello.probe_names = names;
    hello.probes.resize(names.size());
    return to_message(hello);
  };
  const std::string allowed = "allowed: letters, digits and one of \"_-. \"";
  expect_turned_down(with_probes({"u", "a,b"}), {"probe_names: found \"a,b\"", allowed});
  expect_turned_down(with_probes({"c\"d"}), {"probe_names: found \"c\\\"d\"", allowed});
  expect_turned_down(with_probes({""}), {"probe_names: found \"\"", allowed});
  expect_turned_down(with_probes({"A.ux", "v-1", "A.ux"}),
                     {"probe_names: found \"A.ux\" twice, allowed: once"});
  Hello hello = good_hello("soil");
  hello.interfaces[0].name = "my wall";
  expect_turned_down(to_message(hello),
                     {"names of interfaces: found \"my wall\"", "one of \"_-.\""});
  // Twice in the list, with one array of coordinates.
  Message twice = to_message(good_hello("soil"));
  twice.fields["interfaces"].push_back(twice.fields["interfaces"][0]);
  expect_turned_down(twice, {"names of interfaces: found \"wall\" twice"});
  EXPECT_EQ(read_hello(with_probes({"A.ux", "v-1", "left wall.fx"})).probe_names.size(), 3u);
}

TEST(Handshake, participants_error_names_both_values) {
  Server server(patient_settings());
  auto end = std::async(std::launch::async, [endpoint = server.endpoint()] {
    return message_of<ProtocolError>([&] {
      ParticipantSettings settings = participant("soil", endpoint);
      settings.scene_hash = "def";
      DummySolver soil(3, 2, 1.0);
      Connection connection(settings);
      serve(soil, connection);
    });
  });
  message_of<ProtocolError>([&] { server.wait_for({expected("soil")}); });
  const std::string error = end.get();
  EXPECT_NE(error.find("scene hash: coupler abc, participant def"), std::string::npos) << error;
}

TEST(Handshake, who_cannot_begin_ends_the_wait_with_its_reason) {
  Server server(patient_settings());
  ParticipantSettings settings;
  settings.endpoint = server.endpoint();
  settings.name = "soil";
  settings.program = "mpm_solver";
  Connection(settings).abort("mpm.json: at /gravity: found 9.81");
  EXPECT_EQ(message_of<ConfigError>([&] { server.wait_for({expected("soil")}); }),
            "participant \"soil\" (mpm_solver) cannot begin: mpm.json: at /gravity: found 9.81");
}

TEST(Handshake, who_comes_after_the_failure_is_told_why) {
  Switchboard board("tcp://127.0.0.1:*", patient_settings().deadlines);
  RawParticipant stranger(board.endpoint(), "stranger");
  stranger.send_frames({R"({"type":"hello","sequence":1})"});
  RawParticipant late(board.endpoint(), "late");
  late.send(to_message(good_hello("structure")));
  board.abort("participant \"soil\" cannot begin");
  board.turn_away("participant \"soil\" cannot begin", {"structure"}, 50);
  const Message answer = late.receive();
  ASSERT_EQ(answer.type, "abort");
  EXPECT_EQ(answer.text("reason"), "participant \"soil\" cannot begin");
}

TEST(Handshake, strangers_that_cannot_begin_are_not_heard) {
  Server server(patient_settings());
  RawParticipant stranger(server.endpoint(), "stranger");
  stranger.send_frames({R"({"type":"abort","sequence":0})"});
  stranger.send_frames({R"({"type":"abort","sequence":0,"participant":3,"reason":"none"})"});
  stranger.send_frames({R"({"type":"abort","sequence":0,"participant":"gate","reason":"none"})"});
  RawParticipant raw(server.endpoint(), "raw");
  raw.send(to_message(good_hello("soil")));
  EXPECT_EQ(server.wait_for({expected("soil")}).size(), 1u);
}

TEST(Handshake, a_hello_that_is_not_understood_is_answered_and_the_coupler_waits_on) {
  Server server(patient_settings());
  RawParticipant hasty(server.endpoint(), "hasty");
  hasty.send_frames({R"({"type":"hello","participant":"soil"})"});
  auto arrived =
      std::async(std::launch::async, [&] { return server.wait_for({expected("soil")}).size(); });
  const Message answer = hasty.receive();
  RawParticipant raw(server.endpoint(), "raw");
  raw.send(to_message(good_hello("soil")));
  EXPECT_EQ(arrived.get(), 1u);
  ASSERT_EQ(answer.type, "refused");
  EXPECT_NE(answer.text("reason").find("expected an integer \"sequence\""), std::string::npos)
      << answer.text("reason");
}

}  // namespace
}  // namespace gabion::test::test_handshake
