// SPDX-License-Identifier: BSD-3-Clause
// Runs that begin with structures displaced.
#include <gtest/gtest.h>

#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <sstream>

#include "common/run/start.hpp"
#include "coupler/coupling_loop.hpp"
#include "tests/support/solver_server.hpp"
#include "tests/unit/coupler/mass_springs.hpp"

namespace gabion::test::test_start {
namespace {

namespace fs = std::filesystem;

/// A structure that begins displaced, as if it had been held until then.
class DisplacedSprings : public StructureSprings, public DisplacedAtStart {
 public:
  explicit DisplacedSprings(const std::vector<double>& u) : StructureSprings(2, 1, 100) {
    for (Eigen::Index i = 0; i < u_.size(); ++i) {
      u_(i) = u[static_cast<std::size_t>(i)];
      a_(i) = -stiffness_ / mass_ * u_(i);
    }
    energy_at_start = energy();
  }
  InterfaceValues start_displacements() const override {
    return {{mesh_.name, {u_.begin(), u_.end()}}};
  }
  double energy_at_start = 0;
  double energy_now() const { return energy(); }
};

/// A soil that writes down where its interface begins, and where it is in the first solution.
class PlacedSprings : public SoilSprings, public TakesStart {
 public:
  PlacedSprings() : SoilSprings(3, 2, 10) {
    load = [](double) { return 5.0; };
  }
  void set_start(const InterfaceValues& displacements) override {
    start = displacements.at(mesh_.name);
    u_ = Eigen::Map<const Eigen::VectorXd>(start.data(), u_.size());
    EXPECT_EQ(solves, 0);
    EXPECT_TRUE(written.empty());
  }
  StepReport solve_step(const StepRequest& request, const InterfaceValues& received,
                        InterfaceValues& sent) override {
    if (solves == 0) first = received.at(mesh_.name);
    return SoilSprings::solve_step(request, received, sent);
  }
  std::vector<double> start, first;
};

struct Rows {
  std::vector<std::string> names;
  std::vector<std::vector<double>> values;
  double sum(const std::string& name) const {
    const auto at = std::find(names.begin(), names.end(), name) - names.begin();
    double total = 0;
    for (const auto& row : values) total += row.at(static_cast<std::size_t>(at));
    return total;
  }
};

/// Rows of the steps of a run of 0.2 s, up to the columns of wall time and without texts.
Rows run(Solver& soil, Solver& structure, bool wire = false, int predictor = 0,
         Scheme scheme = Scheme::serial_implicit) {
  CouplerSettings s;
  s.time = {0.2, 0.01, 0.01 / 64};
  s.output_interval = 0.05;
  s.participants = {{"soil", true}, {"structure", false}};
  s.interfaces = {{"wall", "soil", "structure"}};
  s.coupling.scheme = scheme;
  s.coupling.predictor = predictor;
  s.coupling.convergence.displacement = {1e-11, 1e-9, 1e-14, {}};
  s.coupling.convergence.force = {1e-8, 1e-9, 1e-12, {}};
  s.coupling.mapping.tolerance = 1e-9;
  const fs::path folder = fs::temp_directory_path() / ("gabion_start_" + std::to_string(getpid()));
  fs::remove_all(folder);
  {
    RunRecord files(folder.string(), "coupler");
    if (wire) {
      couple_through_sockets(s, soil, structure, files);
    } else {
      CouplingLoop(s, {{"structure", structure}, {"soil", soil}}, files).run();
    }
  }
  Rows rows;
  std::ifstream in(folder / "steps.csv");
  for (std::string line; std::getline(in, line);) {
    std::stringstream stream(line);
    std::vector<double> row;
    for (std::string cell; std::getline(stream, cell, ',');) {
      if (line.starts_with("step,")) {
        rows.names.push_back(cell);
      } else {
        row.push_back(cell.find_first_not_of("0123456789+-.e") == std::string::npos && !cell.empty()
                          ? std::stod(cell)
                          : 0);
      }
    }
    if (!row.empty()) rows.values.push_back(row);
  }
  fs::remove_all(folder);
  return rows;
}

const std::vector<double> u0 = {0.5, -0.25, 0.125, 1};                     // of two vertices
const std::vector<double> mapped = {0.5, -0.25, 0.3125, 0.375, 0.125, 1};  // on three

TEST(Start, the_soil_is_told_where_the_structure_begins) {
  for (const bool wire : {false, true}) {
    for (const Scheme scheme : {Scheme::serial_implicit, Scheme::parallel_implicit}) {
      for (const int predictor : {0, 1, 2}) {
        DisplacedSprings structure(u0);
        PlacedSprings soil;
        run(soil, structure, wire, predictor, scheme);
        ASSERT_EQ(soil.start.size(), mapped.size());
        for (std::size_t k = 0; k < mapped.size(); ++k)
          EXPECT_NEAR(soil.start[k], mapped[k], 1e-15);
        EXPECT_EQ(soil.first, soil.start);  // the predictor begins there
      }
    }
  }
}

// The trapezoidal rule turns this work into the structure's energy, from the first step on.
TEST(Start, the_work_of_the_first_step_is_that_from_where_it_begins) {
  DisplacedSprings structure(u0);
  PlacedSprings soil;
  const Rows rows = run(soil, structure);
  const double gained = structure.energy_now() - structure.energy_at_start;
  EXPECT_GT(std::abs(gained), 1);
  EXPECT_NEAR(rows.sum("structure_work"), gained, 1e-8 * structure.energy_at_start);
  EXPECT_NEAR(rows.sum("soil_work") + rows.sum("structure_work"), 0,
              1e-8 * structure.energy_at_start);
}

TEST(Start, nothing_is_told_where_nothing_begins_displaced) {
  DisplacedSprings still({0, 0, 0, 0});
  StructureSprings silent(2, 1, 100);
  PlacedSprings soil, other;
  const Rows rows = run(soil, still), expected = run(other, silent);
  EXPECT_TRUE(soil.start.empty());
  ASSERT_EQ(rows.values.size(), 20u);
  EXPECT_EQ(rows.sum("fx"), expected.sum("fx"));
}

TEST(Start, a_soil_that_does_not_take_it_is_named) {
  DisplacedSprings structure(u0);
  SoilSprings soil(3, 2, 10);
  testing::internal::CaptureStderr();
  run(soil, structure);
  const std::string text = testing::internal::GetCapturedStderr();
  EXPECT_NE(text.find("participant \"soil\" does not take displacements of the start"),
            std::string::npos);
  EXPECT_NE(text.find("\"wall\" by up to 1.01 m"), std::string::npos);
}

}  // namespace
}  // namespace gabion::test::test_start
