// SPDX-License-Identifier: BSD-3-Clause
// Structures whose interfaces get other facets, and soils that are told.
#include <gtest/gtest.h>

#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "common/run/facets.hpp"
#include "coupler/coupling_loop.hpp"
#include "tests/support/expect_error.hpp"
#include "tests/support/solver_server.hpp"
#include "tests/unit/coupler/mass_springs.hpp"

namespace gabion::test::test_changing_facets {
namespace {

namespace fs = std::filesystem;

/// Loses its first facet in a step.
class BreakingSprings : public StructureSprings, public ChangesFacets {
 public:
  explicit BreakingSprings(int step) : StructureSprings(3, 1, 100), step_(step) {}
  InterfaceFacets facets() const override {
    std::vector<std::int64_t> own = mesh_.facets;
    if (accepted >= step_) own.erase(own.begin(), own.begin() + 2);
    return {{mesh_.name, own}};
  }

 private:
  int step_;
};

/// Writes down what it is told, and after how many accepted steps.
class OpenSprings : public SoilSprings, public TakesFacets {
 public:
  explicit OpenSprings(int num_vertices = 3) : SoilSprings(num_vertices, 2, 10) {
    load = [](double) { return 5.0; };
  }
  void set_facets(const InterfaceFacets& facets) override {
    told.push_back({accepted, solves, facets.at(mesh_.name)});
  }
  void lose_first_facet() { mesh_.facets.erase(mesh_.facets.begin(), mesh_.facets.begin() + 2); }
  struct Told {
    int accepted, solves;
    std::vector<std::int64_t> facets;
  };
  std::vector<Told> told;
};

/// @returns  summary of a run of 0.1 s
Json run(Solver& soil, Solver& structure, bool wire, Scheme scheme = Scheme::serial_implicit) {
  CouplerSettings s;
  s.time = {0.1, 0.01, 0.01 / 64};
  s.output_interval = 0.05;
  s.participants = {{"soil", true}, {"structure", false}};
  s.interfaces = {{"wall", "soil", "structure"}};
  s.coupling.scheme = scheme;
  s.coupling.predictor = 2;
  s.coupling.convergence.displacement = {1e-11, 1e-9, 1e-14, {}};
  s.coupling.convergence.force = {1e-8, 1e-9, 1e-12, {}};
  s.coupling.mapping.tolerance = 1e-9;
  const fs::path folder = fs::temp_directory_path() / ("gabion_facets_" + std::to_string(getpid()));
  fs::remove_all(folder);
  Json summary;
  {
    RunRecord files(folder.string(), "coupler");
    if (wire) {
      couple_through_sockets(s, soil, structure, files);
    } else {
      CouplingLoop(s, {{"structure", structure}, {"soil", soil}}, files).run();
    }
    std::ifstream(folder / "summary.json") >> summary;
  }
  fs::remove_all(folder);
  return summary;
}

/// The soil gets the facets between the step in which they changed and the next one.
TEST(ChangingFacets, the_soil_is_told_after_the_step_in_which_they_changed) {
  for (const bool wire : {false, true}) {
    for (const Scheme scheme : {Scheme::serial_implicit, Scheme::parallel_implicit}) {
      BreakingSprings structure(4);
      OpenSprings soil;
      const Json summary = run(soil, structure, wire, scheme);
      ASSERT_EQ(soil.told.size(), 1U) << wire;
      EXPECT_EQ(soil.told[0].accepted, 4);
      EXPECT_EQ(soil.told[0].facets, (std::vector<std::int64_t>{2, 1}));
      EXPECT_EQ(soil.accepted, 10);
      EXPECT_GE(summary.at("history_resets"), 1);
    }
  }
}

TEST(ChangingFacets, soils_that_cannot_follow_are_refused) {
  for (const bool wire : {false, true}) {
    BreakingSprings structure(4);
    SoilSprings fixed(3, 2, 10);
    expect_error<ConfigError>([&] { run(fixed, structure, wire); },
                              {"interface \"wall\"", "\"soil\" cannot take other facets"});
    OpenSprings finer(5);
    BreakingSprings other(4);
    expect_error<ConfigError>([&] { run(finer, other, wire); },
                              {"interface \"wall\"", "\"soil\" has other vertices"});
    OpenSprings fewer;
    fewer.lose_first_facet();
    BreakingSprings whole(4);
    expect_error<ConfigError>(
        [&] { run(fewer, whole, wire); },
        {"interface \"wall\": \"structure\" begins with 2 facets, \"soil\" with 1, of which 1 are",
         "\"groups\""});
  }
}

}  // namespace
}  // namespace gabion::test::test_changing_facets
