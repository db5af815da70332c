// SPDX-License-Identifier: BSD-3-Clause
// Soil on an interface that gets other facets.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "mpm_solver/placed_soil.hpp"
#include "tests/support/expect_error.hpp"
#include "tests/unit/mpm/mpm_scene.hpp"

namespace gabion::test::test_changing_facets {
namespace {

constexpr double dt = 1.0 / 1024;

/// A block that has 4 m/s when it meets a floor two cells thick, whose cells may leave.
template <int dim>
Json on_floor() {
  const bool flat = dim == 2;
  const Json mesh = flat ? box({0, 0}, {1, 0.5}, {8, 2}, "quad4")
                         : box({0, 0, 0}, {1, 1, 0.5}, {4, 4, 2}, "hex8");
  const Json soil = flat ? box({0.25, 0.5}, {0.75, 0.75}, {4, 2}, "quad4")
                         : box({0.25, 0.25, 0.5}, {0.75, 0.75, 0.75}, {2, 2, 1}, "hex8");
  const std::vector<double> down =
      flat ? std::vector<double>{0, -4} : std::vector<double>{0, 0, -4};
  return {{"dimension", dim},
          {"grid", flat ? box({0, -1}, {1, 1}, {8, 16}, "quad4")
                        : box({0, 0, -1}, {1, 1, 1}, {4, 4, 8}, "hex8")},
          {"basis", "linear"},
          {"gravity", std::vector<double>(dim, 0.0)},
          {"bodies",
           {body("soil", soil, flat ? 4 : 8, elastic_soil("neo_hookean", 1e5, 0.3, 1000), down)}},
          {"interfaces",
           {{{"name", "floor"},
             {"method", "facets"},
             {"surface", {{"mesh", mesh}, {"groups", {"top"}}, {"behind", {"all"}}}}}}}};
}

template <int dim>
struct Fall {
  explicit Fall(const std::string& scheme = "newmark") : soil(comm(), settings(scheme), "") {}
  static mpm::MpmSettings<dim> settings(const std::string& scheme) {
    Json json = on_floor<dim>();
    json["time_integration"] = {{"scheme", scheme}};
    return mpm_settings<dim>(json);
  }

  mpm::PlacedSoil<dim> soil;
  InterfaceMesh mesh = soil.interfaces().front();
  int n = 0;

  /// Forces on the floor, which rests.
  std::vector<double> step() {
    InterfaceValues sent, rest;
    rest["floor"].assign(mesh.coordinates.size(), 0.0);
    const StepRequest request{++n, 0, (n - 1) * dt, dt};
    soil.solve_step(request, rest, sent);
    soil.accept_step(request, true);
    return sent.at("floor");
  }
  std::vector<std::int64_t> vertices(std::size_t facet) const {
    const auto first = mesh.facets.begin() + std::ptrdiff_t(facet) * mesh.vertices_per_facet;
    return {first, first + mesh.vertices_per_facet};
  }
  /// The facets on one side of the middle, x < 0.5 or beyond.
  std::vector<std::int64_t> half(bool low) const {
    std::vector<std::int64_t> facets;
    for (std::size_t f = 0; f < mesh.facets.size() / mesh.vertices_per_facet; ++f) {
      double x = 0;
      for (const std::int64_t v : vertices(f)) x += mesh.coordinates[v * dim];
      if ((x / mesh.vertices_per_facet < 0.5) != low) continue;
      for (const std::int64_t v : vertices(f)) facets.push_back(v);
    }
    return facets;
  }
  double energy() const {
    double sum = 0;
    for (const char* name : {"kinetic_energy", "elastic_energy", "contact_energy", "contact_loss",
                             "contact_friction"}) {
      sum += probe(soil, name);
    }
    return sum;
  }
};

double largest(const std::vector<double>& forces) {
  double value = 0;
  for (const double f : forces) value = std::max(value, std::abs(f));
  return value;
}

template <int dim>
void expect_force_on_facets_alone(const std::string& scheme) {
  SCOPED_TRACE(scheme);
  Fall<dim> fall(scheme);
  for (int k = 0; k < 8; ++k) fall.step();
  const std::vector<double> before = fall.step();
  ASSERT_GT(largest(before), 0);
  const double stored = probe(fall.soil, "contact_energy"), lost = probe(fall.soil, "contact_loss");
  const std::vector<std::int64_t> kept = fall.half(true);
  fall.soil.set_facets({{"floor", kept}});
  // What the springs held at half of the facets is lost at once; nothing is made.
  EXPECT_NEAR(probe(fall.soil, "contact_energy"), stored, 1e-12 * stored);  // of the last step
  const double sum = fall.energy();
  const std::vector<double> forces = fall.step();
  EXPECT_GT(probe(fall.soil, "contact_loss"), lost + 0.1 * stored);
  EXPECT_LE(fall.energy(), sum * (1 + 1e-9));
  double on_kept = 0;
  for (std::int64_t v = 0; v < fall.mesh.num_vertices(); ++v) {
    const double f = std::abs(forces[v * dim + dim - 1]);
    if (std::ranges::find(kept, v) == kept.end()) {
      EXPECT_EQ(f, 0) << v;
    }
    on_kept += f;
  }
  EXPECT_GT(on_kept, 0);
  // The force of the contacts that left has no part in the next step.
  const double momentum = probe(fall.soil, "mass") * 4;
  const std::string axis = dim == 2 ? "momentum_error_y" : "momentum_error_z";
  EXPECT_NEAR(probe(fall.soil, axis), 0, 1e-6 * momentum);
}

TEST(ChangingFacets, force_comes_to_facets_that_are_left) {
  for (const char* scheme : {"newmark", "explicit"}) {
    expect_force_on_facets_alone<2>(scheme);
    expect_force_on_facets_alone<3>(scheme);
  }
}

/// Without facets the block flies on with what velocity it has; with those that were behind it
/// meets them.
TEST(ChangingFacets, soil_falls_through_to_the_next_layer) {
  Fall<2> fall;
  for (int k = 0; k < 4; ++k) fall.step();
  fall.soil.set_facets({{"floor", {}}});
  for (int k = 0; k < 8; ++k) EXPECT_EQ(largest(fall.step()), 0);
  Fall<2> layer;
  for (int k = 0; k < 4; ++k) layer.step();
  std::vector<std::int64_t> lower;  // the faces between the two layers of cells
  for (int i = 8; i > 0; --i) {
    for (const double x : {i / 8.0, (i - 1) / 8.0}) {
      for (std::int64_t v = 0; v < layer.mesh.num_vertices(); ++v) {
        if (layer.mesh.coordinates[2 * v] == x && layer.mesh.coordinates[2 * v + 1] == 0.25) {
          lower.push_back(v);
        }
      }
    }
  }
  ASSERT_EQ(lower.size(), 16U);
  layer.soil.set_facets({{"floor", lower}});
  int until = 0;
  while (largest(layer.step()) == 0 && until < 200) ++until;
  const double time = until * dt;
  EXPECT_NEAR(time, 0.25 / 4, 0.2 * 0.25 / 4);  // the way to the next layer
}

TEST(ChangingFacets, the_same_facets_change_nothing) {
  Fall<2> fall, other;
  for (int k = 0; k < 20; ++k) {
    if (k == 6) other.soil.set_facets({{"floor", other.mesh.facets}});
    EXPECT_EQ(fall.step(), other.step()) << k;
  }
}

template <int dim>
void expect_restart() {
  Fall<dim> fall, other;
  for (int k = 0; k < 8; ++k) fall.step();
  fall.soil.set_facets({{"floor", fall.half(false)}});
  const State state = fall.soil.save_state();
  other.soil.load_state(state);
  other.n = fall.n;
  for (int k = 0; k < 12; ++k) {
    EXPECT_EQ(fall.step(), other.step()) << k;
    if (k != 0) continue;
    fall.soil.set_facets({{"floor", fall.half(true)}});
    other.soil.set_facets({{"floor", fall.half(true)}});
  }
}

TEST(ChangingFacets, a_restart_gives_the_same_bits) {
  expect_restart<2>();
  expect_restart<3>();
}

/// A state whose facets are no list of vertices must not go on with those of the beginning.
TEST(ChangingFacets, a_state_with_broken_facets_is_refused) {
  Fall<2> fall;
  fall.soil.set_facets({{"floor", fall.half(false)}});
  for (const Json& broken : {Json("0 1"), Json(), Json({0, "1"}), Json({0, 0.5})}) {
    State state = fall.soil.save_state();
    state.facts["facets.floor"] = broken;
    Fall<2> other;
    expect_error<Error>([&] { other.soil.load_state(state); },
                        {"saved state: \"facets.floor\"", "allowed: a list of vertices"});
  }
}

TEST(ChangingFacets, what_cannot_change_is_refused) {
  Fall<2> fall;
  expect_error<Error>([&] { fall.soil.set_facets({{"floor", {0, 1, 2}}}); }, {"2 a facet"});
  expect_error<Error>([&] { fall.soil.set_facets({{"floor", {0, 99}}}); }, {"vertex 99", "0 to"});
  expect_error<Error>([&] { fall.soil.set_facets({{"roof", {0, 1}}}); }, {"\"roof\""});
  Json json = on_floor<2>();
  json["interfaces"][0]["method"] = "boundary_points";
  expect_error<ConfigError>([&] { mpm_settings<2>(json); },
                            {"/interfaces/0/surface/behind", "\"method\": \"facets\""});
  json = on_floor<2>();
  json["rigid_walls"] = json["interfaces"];
  json.erase("interfaces");
  expect_error<ConfigError>([&] { mpm_settings<2>(json); },
                            {"/rigid_walls/0/surface/behind", "allowed of interfaces"});
  json = on_floor<2>();
  json["interfaces"][0]["surface"]["behind"] = {"stone"};
  expect_error<ConfigError>([&] { mpm_settings<2>(json); },
                            {"/interfaces/0/surface/behind", "\"stone\"", "allowed: all"});
}

}  // namespace
}  // namespace gabion::test::test_changing_facets
