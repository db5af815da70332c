// SPDX-License-Identifier: BSD-3-Clause
// Facets that leave an interface: said by a structure and taken by a soil with time loops of their
// own, in C++ and C.
#include <gtest/gtest.h>

#include <future>

#include "common/base/require.hpp"
#include "common/run/facets.hpp"
#include "dummy_solver.hpp"
#include "protocol/gabion_participant.h"
#include "protocol/participant.hpp"
#include "tests/support/expect_error.hpp"

namespace gabion::test::test_participant_facets {
namespace {

using Facets = std::vector<std::int64_t>;

const std::vector<double> coordinates = {0, 0, 0, 1, 0, 2};
const std::vector<double> zero(6, 0);
const Facets all = {0, 1, 1, 2}, upper = {1, 2};

/// A coupler, and one participant whose side runs in a thread.
class FacetsOf : public testing::Test {
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
  /// One accepted step of 0.1 s.
  static void step(Solver& solver, int number) {
    const StepRequest request{number, 0, 0.1 * (number - 1), 0.1};
    InterfaceValues sent;
    solver.solve_step(request, {{"wall", zero}}, sent);
    solver.accept_step(request, true);
  }
  /// The lower facet leaves in step 2, the upper one in step 3; a state of step 2 has the upper
  /// one.
  void expect_run_of_a_structure(Solver& structure) {
    EXPECT_EQ(changing_interfaces(structure), std::vector<std::string>{"wall"});
    EXPECT_FALSE(takes_facets(structure));
    State saved;
    for (const auto& [number, facets] :
         {std::pair(1, all), std::pair(2, upper), std::pair(3, Facets()), std::pair(4, Facets())}) {
      step(structure, number);
      EXPECT_EQ(changing_facets(structure).at("wall"), facets) << number;
      if (number == 2) saved = structure.save_state();
    }
    structure.load_state(saved);
    InterfaceValues sent;
    const StepRequest third{3, 0, 0.2, 0.1};
    structure.solve_step(third, {}, sent);
    structure.reject_step();
    structure.solve_step(third, {}, sent);
    structure.accept_step(third, true);
    EXPECT_TRUE(changing_facets(structure).at("wall").empty());
    finish();
  }

  std::unique_ptr<Server> server_;
  std::map<std::string, std::unique_ptr<Solver>> solvers_;
  std::future<void> end_;
};

Facets facets_after(int steps) {
  return steps < 2 ? all : steps == 2 ? upper : Facets();
}

TEST_F(FacetsOf, a_structure_says_which_it_has) {
  expect_run_of_a_structure(meet("structure", [](const ParticipantSettings& settings) {
    int steps = 0;
    Participant p(settings);
    p.set_interface("wall", coordinates, 2, all);
    p.set_facets_may_change("wall");
    p.set_state([&] { return std::vector<std::byte>(1, std::byte(steps)); },
                [&](std::span<const std::byte> state) {
                  steps = static_cast<int>(state[0]);
                  p.write_facets("wall", facets_after(steps));
                });
    p.initialize();
    while (p.is_coupling_ongoing()) {
      p.requires_writing_checkpoint();
      p.write_data("wall", zero);
      p.advance(p.get_max_time_step_size());
      if (p.requires_reading_checkpoint()) {
        expect_error<UsageError>([&] { p.write_facets("wall", upper); },
                                 {"after an accepted step"});
        continue;
      }
      p.write_facets("wall", facets_after(++steps));
    }
  }));
}

/// What a code in C has: its number of accepted steps, and how it talks.
struct CodeInC {
  gabion_participant* p;
  char steps;
};

gabion_status write_in_c(const CodeInC& code) {
  const Facets facets = facets_after(code.steps);
  return gabion_write_facets(code.p, "wall", facets.size() / 2, facets.data());
}
int save_in_c(const void** data, size_t* size, void* user) {
  *data = &static_cast<CodeInC*>(user)->steps;
  *size = 1;
  return 0;
}
int load_in_c(const void* data, size_t, void* user) {
  auto& code = *static_cast<CodeInC*>(user);
  code.steps = *static_cast<const char*>(data);
  return write_in_c(code) == GABION_OK ? 0 : 1;
}

TEST_F(FacetsOf, the_same_in_c) {
  expect_run_of_a_structure(meet("structure", [](const ParticipantSettings& settings) {
    CodeInC code{gabion_create(settings.name.c_str(), settings.endpoint.c_str(), 2, "force"), 0};
    gabion_participant* p = code.p;
    EXPECT_EQ(gabion_set_interface(p, "wall", 3, coordinates.data(), 2, 2, all.data()), GABION_OK);
    EXPECT_EQ(gabion_set_facets_may_change(p, "wall"), GABION_OK);
    EXPECT_EQ(gabion_set_state(p, save_in_c, load_in_c, &code), GABION_OK);
    EXPECT_EQ(gabion_initialize(p), GABION_OK) << gabion_last_error(p);
    int answer = 0;
    while (gabion_is_coupling_ongoing(p, &answer) == GABION_OK && answer == 1) {
      double dt = 0;
      gabion_requires_writing_checkpoint(p, &answer);
      gabion_get_max_time_step_size(p, &dt);
      gabion_write_data(p, "wall", zero.data(), 6);
      EXPECT_EQ(gabion_advance(p, dt), GABION_OK) << gabion_last_error(p);
      gabion_requires_reading_checkpoint(p, &answer);
      if (answer == 1) continue;
      ++code.steps;
      EXPECT_EQ(write_in_c(code), GABION_OK) << gabion_last_error(p);
    }
    gabion_destroy(p);
  }));
}

TEST_F(FacetsOf, a_soil_takes_others_between_steps) {
  std::vector<std::string> calls;
  Facets taken;
  Solver& soil = meet("soil", [&](const ParticipantSettings& settings) {
    Participant p(settings);
    p.set_interface("wall", coordinates, 2, all);
    p.on_set_facets([&](const InterfaceFacets& facets) {
      taken = facets.at("wall");
      calls.push_back("facets");
    });
    p.initialize();
    while (p.is_coupling_ongoing()) {
      if (p.requires_writing_checkpoint()) calls.push_back("save");
      p.write_data("wall", zero);
      p.advance(p.get_max_time_step_size());
      p.requires_reading_checkpoint();
    }
  });
  EXPECT_TRUE(takes_facets(soil));
  step(soil, 1);
  set_facets(soil, {{"wall", upper}});
  EXPECT_EQ(taken, upper);
  step(soil, 2);
  finish();
  EXPECT_EQ(calls, (std::vector<std::string>{"save", "facets", "save"}));
}

int take_in_c(const char* name, size_t num_facets, const int64_t* facets, void* user) {
  static_cast<InterfaceFacets*>(user)->emplace(name, Facets(facets, facets + 2 * num_facets));
  return name == std::string("wall") ? 0 : 1;
}

TEST_F(FacetsOf, a_soil_in_c_takes_others) {
  InterfaceFacets taken;
  Solver& soil = meet("soil", [&](const ParticipantSettings& settings) {
    gabion_participant* p =
        gabion_create(settings.name.c_str(), settings.endpoint.c_str(), 2, "displacement");
    EXPECT_EQ(gabion_set_interface(p, "wall", 3, coordinates.data(), 2, 2, all.data()), GABION_OK);
    EXPECT_EQ(gabion_on_set_facets(p, take_in_c, &taken), GABION_OK);
    EXPECT_EQ(gabion_initialize(p), GABION_OK) << gabion_last_error(p);
    gabion_destroy(p);
  });
  set_facets(soil, {{"wall", upper}});
  EXPECT_EQ(taken, (InterfaceFacets{{"wall", upper}}));
  finish();
}

TEST_F(FacetsOf, a_state_without_them_ends_the_run) {
  Solver& structure = meet("structure", [](const ParticipantSettings& settings) {
    Participant p(settings);
    p.set_interface("wall", coordinates, 2, all);
    p.set_facets_may_change("wall");
    p.set_state([] { return std::vector<std::byte>(); }, [](std::span<const std::byte>) {});
    expect_error<UsageError>([&] { p.initialize(); }, {"no facets were written for \"wall\""});
  });
  const State saved = structure.save_state();
  expect_error<ProtocolError>([&] { structure.load_state(saved); }, {"no facets were written"});
  end_.get();
}

TEST(FacetCalls, wrong_ones_are_named) {
  Participant structure(participant("structure", "tcp://127.0.0.1:9"));
  Participant soil(participant("soil", "tcp://127.0.0.1:9"));
  for (Participant* p : {&structure, &soil}) p->set_interface("wall", coordinates, 2, all);
  structure.set_interface("points", coordinates);
  expect_error<UsageError>([&] { structure.set_facets_may_change("roof"); },
                           {"found interface \"roof\", allowed: [\"wall\""});
  expect_error<UsageError>([&] { structure.set_facets_may_change("points"); },
                           {"interface \"points\" without facets"});
  expect_error<UsageError>([&] { structure.write_facets("wall", upper); },
                           {"found interface \"wall\", allowed: those of set_facets_may_change"});
  structure.set_facets_may_change("wall");
  expect_error<UsageError>([&] { structure.write_facets("wall", upper); },
                           {"allowed after an accepted step"});
  expect_error<UsageError>([&] { soil.set_facets_may_change("wall"); },
                           {"found a participant that sends force, allowed: one that sends displ"});
  expect_error<UsageError>([&] { structure.on_set_facets([](const InterfaceFacets&) {}); },
                           {"found a participant that receives force, allowed: one that receives"});
  expect_error<UsageError>([&] { soil.on_set_facets({}); },
                           {"on_set_facets: found an empty function"});
}

}  // namespace
}  // namespace gabion::test::test_participant_facets
