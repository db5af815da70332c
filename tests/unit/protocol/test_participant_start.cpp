// SPDX-License-Identifier: BSD-3-Clause
// Where interfaces begin: said by a structure and taken by a soil with time loops of their own, in
// C++ and C.
#include <gtest/gtest.h>

#include <future>
#include <limits>

#include "common/base/require.hpp"
#include "common/run/start.hpp"
#include "dummy_solver.hpp"
#include "protocol/gabion_participant.h"
#include "protocol/participant.hpp"
#include "tests/support/expect_error.hpp"

namespace gabion::test::test_participant_start {
namespace {

const std::vector<double> coordinates = {0, 0, 0, 1, 0, 2};
const std::vector<double> start = {0, 0, 1.0 / 3, -0.25, 1e-300, 2};

/// A coupler, and one participant whose side runs in a thread.
class Start : public testing::Test {
 protected:
  Solver& meet(const std::string& name, std::function<void(const ParticipantSettings&)> run) {
    server_ = std::make_unique<Server>(patient_settings());
    const auto settings = participant(name, server_->endpoint());
    end_ = std::async(std::launch::async, [settings, run] { return run(settings); });
    solvers_ = server_->wait_for({expected(name)});
    return *solvers_.at(name);
  }
  void finish() {
    server_->finish();
    end_.get();
  }

  std::unique_ptr<Server> server_;
  std::map<std::string, std::unique_ptr<Solver>> solvers_;
  std::future<void> end_;
};

TEST_F(Start, a_structure_says_where_it_begins) {
  const std::vector<double> zero(6, 0);
  for (const auto& [u, count] : {std::pair(start, 1U), std::pair(zero, 0U)}) {
    Solver& structure = meet("structure", [&](const ParticipantSettings& settings) {
      Participant p(settings);
      p.set_interface("wall", coordinates);
      p.set_start_displacement("wall", start);
      p.set_start_displacement("wall", u);  // the last one holds
      p.initialize();
      p.finalize();
    });
    EXPECT_FALSE(takes_start(structure));
    const InterfaceValues said = start_displacements(structure);
    EXPECT_EQ(said.size(), count);
    if (count > 0) {
      EXPECT_EQ(said.at("wall"), u);
    }
    finish();
  }
}

TEST_F(Start, a_soil_takes_it_before_its_first_step) {
  std::vector<std::string> calls;
  std::vector<double> taken, received;
  Solver& soil = meet("soil", [&](const ParticipantSettings& settings) {
    Participant p(settings);
    p.set_interface("wall", coordinates);
    p.set_probes({"top"}, std::vector<double>{1});
    p.on_set_start([&](const InterfaceValues& displacements) {
      taken = displacements.at("wall");
      calls.push_back("start");
      p.write_probes(std::vector<double>{7});
    });
    p.set_output([&](double) { calls.push_back("write"); });
    p.initialize();
    while (p.is_coupling_ongoing()) {
      if (p.requires_writing_checkpoint()) calls.push_back("save");
      received = p.read_data("wall");
      p.write_data("wall", std::vector<double>(6, 0));
      p.advance(p.get_max_time_step_size());
      p.requires_reading_checkpoint();
    }
  });
  EXPECT_TRUE(takes_start(soil));
  EXPECT_EQ(soil.probes(), std::vector<double>{1});
  set_start(soil, {{"wall", start}});
  EXPECT_EQ(taken, start);
  EXPECT_EQ(soil.probes(), std::vector<double>{7});
  soil.write_output(0);
  InterfaceValues sent;
  soil.solve_step({1, 0, 0, 0.1}, {{"wall", start}}, sent);
  EXPECT_EQ(received, start);  // total, from the reference
  EXPECT_EQ(soil.accept_step({1, 0, 0, 0.1}, true).probes, std::vector<double>{7});
  finish();
  EXPECT_EQ(calls, (std::vector<std::string>{"start", "write", "save"}));
}

TEST_F(Start, a_place_where_it_cannot_begin_ends_the_run) {
  Solver& soil = meet("soil", [](const ParticipantSettings& settings) {
    Participant p(settings);
    p.set_interface("wall", coordinates);
    p.on_set_start([](const InterfaceValues&) { throw Error("soil inside the wall"); });
    expect_error<Error>([&] { p.initialize(); }, {"soil inside the wall"});
  });
  expect_error<ProtocolError>(
      [&] {
        set_start(soil, {{"wall", start}});
      },
      {"soil inside the wall"});
  end_.get();
}

TEST_F(Start, a_soil_that_does_not_take_it_says_so) {
  Solver& soil = meet("soil", [](const ParticipantSettings& settings) {
    Participant p(settings);
    p.set_interface("wall", coordinates);
    p.initialize();
    p.finalize();
  });
  EXPECT_FALSE(takes_start(soil));
  finish();
}

int take_in_c(const char* name, const double* values, size_t count, void* user) {
  auto& taken = *static_cast<InterfaceValues*>(user);
  taken[name] = {values, values + count};
  return name == std::string("wall") ? 0 : 1;
}

TEST_F(Start, the_same_in_c) {
  const double* u = start.data();
  const auto made = [](const ParticipantSettings& settings, const char* receives) {
    gabion_participant* p =
        gabion_create(settings.name.c_str(), settings.endpoint.c_str(), 2, receives);
    EXPECT_EQ(gabion_set_interface(p, "wall", 3, coordinates.data(), 0, 0, nullptr), GABION_OK);
    return p;
  };
  Solver& structure = meet("structure", [&](const ParticipantSettings& settings) {
    gabion_participant* p = made(settings, "force");
    EXPECT_EQ(gabion_set_start_displacement(p, "wall", u, 6), GABION_OK);
    EXPECT_EQ(gabion_initialize(p), GABION_OK) << gabion_last_error(p);
    gabion_destroy(p);
  });
  EXPECT_EQ(start_displacements(structure).at("wall"), start);
  finish();
  InterfaceValues taken;
  Solver& soil = meet("soil", [&](const ParticipantSettings& settings) {
    gabion_participant* p = made(settings, "displacement");
    EXPECT_EQ(gabion_on_set_start(p, take_in_c, &taken), GABION_OK);
    EXPECT_EQ(gabion_initialize(p), GABION_OK) << gabion_last_error(p);
    gabion_destroy(p);
  });
  set_start(soil, {{"wall", start}});
  EXPECT_EQ(taken, (InterfaceValues{{"wall", start}}));
  finish();
}

TEST(StartCalls, wrong_ones_are_named) {
  Participant structure(participant("structure", "tcp://127.0.0.1:9"));
  Participant soil(participant("soil", "tcp://127.0.0.1:9"));
  const auto nothing = [](const InterfaceValues&) {};
  for (Participant* p : {&structure, &soil}) p->set_interface("wall", coordinates);
  expect_error<UsageError>([&] { structure.set_start_displacement("roof", start); },
                           {"found interface \"roof\", allowed: [\"wall\"]"});
  expect_error<UsageError>(
      [&] {
        structure.set_start_displacement("wall", {start.data(), 4});
      },
      {"set_start_displacement: found 4 values for \"wall\", allowed: 6"});
  expect_error<UsageError>([&] { soil.set_start_displacement("wall", start); },
                           {"found a participant that sends force, allowed: one that sends displ"});
  expect_error<UsageError>([&] { structure.on_set_start(nothing); },
                           {"found a participant that receives force, allowed: one that receives"});
  expect_error<UsageError>([&] { soil.on_set_start({}); },
                           {"on_set_start: found an empty function"});
  std::vector<double> unknown = start;
  unknown[3] = std::numeric_limits<double>::quiet_NaN();
  structure.set_start_displacement("wall", unknown);
  expect_error<UsageError>([&] { structure.initialize(); },
                           {"displacement:wall", "vertex 1", "component 1"});
}

}  // namespace
}  // namespace gabion::test::test_participant_start
