// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "mpm_solver/gauges/gauge.hpp"
#include "tests/support/expect_error.hpp"
#include "tests/unit/mpm/mpm_scene.hpp"

namespace gabion::test::test_gauges {
namespace {

using mpm::Gauge;

Json gauge(const std::string& name, const std::vector<std::vector<double>>& corners) {
  return {{"name", name}, {"corners", corners}};
}

void take_steps(Solver& solver, double dt, int first, int count) {
  InterfaceValues sent;
  for (int n = first; n < first + count; ++n) {
    const StepRequest request{n, 0, (n - 1) * dt, dt};
    solver.solve_step(request, {}, sent);
    solver.accept_step(request, true);
  }
}

TEST(Gauges, a_way_crosses_in_its_direction_and_once) {
  const Gauge<2> line("line", {Vector<2>(1, 0), Vector<2>(1, 2)});
  EXPECT_EQ(line.normal, Vector<2>(1, 0));
  EXPECT_EQ(line.crossing({0, 1}, {3, 1}), 1);
  EXPECT_EQ(line.crossing({3, 1}, {0, 1}), -1);
  EXPECT_EQ(line.crossing({0, 1}, {1, 1}) + line.crossing({1, 1}, {2, 1}), 1);
  EXPECT_EQ(line.crossing({0, 1}, {1, 1}) + line.crossing({1, 1}, {0, 1}), 0);
  EXPECT_EQ(line.crossing({0, 0}, {2, 0}), 1);   // the foot belongs to it
  EXPECT_EQ(line.crossing({0, 2}, {2, 2}), 0);   // the top to what lies above
  EXPECT_EQ(line.crossing({0, 1}, {2, -2}), 0);  // below the foot, both ends beside the segment
  const Gauge<3> slanted("slanted", {Vector<3>(0, 0, 0), Vector<3>(0, 2, 0), Vector<3>(0, 1, 1)});
  EXPECT_EQ(slanted.normal, Vector<3>(1, 0, 0));
  EXPECT_DOUBLE_EQ(slanted.size, 2);
  EXPECT_DOUBLE_EQ(slanted.height, std::sqrt(2));
  EXPECT_EQ(slanted.crossing({-1, 1.2, 0.5}, {1, 1.2, 0.5}), 1);
  EXPECT_EQ(slanted.crossing({-1, 0.4, 0.5}, {1, 0.4, 0.5}), 0);
  EXPECT_EQ(slanted.crossing({-1, 2.4, 0.5}, {1, 2.4, 0.5}), 1);
  EXPECT_EQ(slanted.crossing({1, 2.4, 0.5}, {-1, 2.4, 0.5}), -1);
}

/// A block of 1 m that flies at 4 m/s through a gauge at x = 1.7 m, its lower side 0.5 m above the
/// foot; in 3D half as wide as the gauge.
Json flying(int dim, const std::string& basis) {
  std::vector<double> low(dim, 0), high(dim, 2), from(dim, 0.5), to(dim, 1.5), v(dim, 0);
  high[0] = 4;
  v[0] = 4;
  std::vector<int> cells(dim, 8), parts(dim, 4);
  cells[0] = 16;
  std::vector<std::vector<double>> corners = {{1.7, 0}, {1.7, 2}};
  if (dim == 3) corners = {{1.7, 0, 0}, {1.7, 2, 0}, {1.7, 0, 2}};
  const std::string type = dim == 2 ? "quad4" : "hex8";
  return {{"dimension", dim},
          {"grid", box(low, high, cells, type)},
          {"basis", basis},
          {"bodies",
           {body("block", box(from, to, parts, type), dim == 2 ? 4 : 8,
                 elastic_soil("hencky_elastic", 1e4, 0.3, 1000), v)}},
          {"gauges", {gauge("g", corners)}},
          {"newton", exact_newton}};
}

/// Flux, depth and speed of a rigid motion have closed forms.
TEST(Gauges, a_block_that_flies_through) {
  for (const auto& [dim, basis] :
       {std::pair{2, "linear"}, {2, "gimp"}, {3, "linear"}, {3, "gimp"}}) {
    SCOPED_TRACE(basis + std::to_string(dim));
    const auto solver = make_mpm(flying(dim, basis));
    EXPECT_EQ(probe(*solver, "g.depth"), 0);
    const double dt = 0.02;
    double through = 0;
    for (int n = 1; n <= 20; ++n) {
      take_steps(*solver, dt, n, 1);
      through += dt * probe(*solver, "g.mass_flux");
      const double front = 1.5 + 4 * dt * n, rear = front - 1;
      if (front > 1.7 + 0.25 && rear < 1.7 - 0.25) {  // the slab is full
        EXPECT_NEAR(probe(*solver, "g.depth"), dim == 2 ? 1 : 0.5, 1e-9);
        EXPECT_NEAR(probe(*solver, "g.area"), 1, 1e-9);
        EXPECT_NEAR(probe(*solver, "g.top"), 1.5, basis == std::string("gimp") ? 1e-9 : 0.02);
        EXPECT_NEAR(probe(*solver, "g.section_flux"), 4000, 1e-5);
      }
      if (front < 1.7 - 0.125 || rear > 1.7 + 0.125) continue;
      EXPECT_NEAR(probe(*solver, "g.normal_speed"), 4, 1e-9);
      EXPECT_NEAR(probe(*solver, "g.speed"), 4, 1e-9);
      EXPECT_NEAR(probe(*solver, "g.max_speed"), 4, 1e-9);
      EXPECT_NEAR(probe(*solver, "g.dynamic_pressure"), 16000, 1e-4);
      EXPECT_NEAR(probe(*solver, "g.passed_mass"), 1000 * std::clamp(front - 1.7, 0.0, 1.0),
                  1000 * 0.14);
      EXPECT_NEAR(probe(*solver, "g.passed_momentum_x"), 4 * probe(*solver, "g.passed_mass"), 1e-6);
    }
    EXPECT_NEAR(probe(*solver, "g.passed_mass"), 1000, 1e-9);
    EXPECT_NEAR(through, 1000, 1e-9);
    EXPECT_NEAR(probe(*solver, "g.passed_momentum_x"), 4000, 1e-6);
    EXPECT_EQ(probe(*solver, "g.depth"), 0);
    EXPECT_EQ(probe(*solver, "g.max_speed"), 0);
  }
}

/// Soil that yields as it falls on the ground and flows in all directions.
Json heap(int dim) {
  std::vector<double> low(dim, 0.0), high(dim, 2.0), from(dim, 0.75), to(dim, 1.25);
  std::vector<double> gravity(dim, 0.0), v(dim, 0.4);
  from[dim - 1] = 0.1;
  to[dim - 1] = 1.1;
  gravity[dim - 1] = -9.81;
  v[dim - 1] = -3;
  Json material = elastic_soil("mohr_coulomb", 1e5, 0.3, 1000);
  material["friction_angle"] = 20;
  const std::string type = dim == 2 ? "quad4" : "hex8";
  std::vector<int> parts(dim, 2);
  parts[dim - 1] = 4;
  return {{"dimension", dim},
          {"grid", box(low, high, std::vector<int>(dim, 8), type)},
          {"basis", "gimp"},
          {"walls", {wall("bottom", "slip")}},
          {"gravity", gravity},
          {"bodies", {body("soil", box(from, to, parts, type), dim == 2 ? 4 : 8, material, v)}}};
}

/// Gauges around x from 0.8 to 1.2 (and y in 3D), up to a height of 0.6 m; all look outwards.
Json cage(int dim) {
  if (dim == 2) {
    return {gauge("right", {{1.2, 0}, {1.2, 0.6}}), gauge("top", {{1.2, 0.6}, {0.8, 0.6}}),
            gauge("left", {{0.8, 0.6}, {0.8, 0}})};
  }
  return {gauge("right", {{1.2, 0.8, 0}, {1.2, 1.2, 0}, {1.2, 0.8, 0.6}}),
          gauge("left", {{0.8, 1.2, 0}, {0.8, 0.8, 0}, {0.8, 1.2, 0.6}}),
          gauge("back", {{1.2, 1.2, 0}, {0.8, 1.2, 0}, {1.2, 1.2, 0.6}}),
          gauge("front", {{0.8, 0.8, 0}, {1.2, 0.8, 0}, {0.8, 0.8, 0.6}}),
          gauge("top", {{0.8, 0.8, 0.6}, {1.2, 0.8, 0.6}, {0.8, 1.2, 0.6}})};
}

template <int dim>
double mass_in_cage(const mpm::MpmSolver<dim>& solver) {
  double sum = 0;
  for (std::int32_t p = 0; p < solver.points().size(); ++p) {
    const Vector<dim>& x = solver.points().x[p];
    bool inside = x[dim - 1] < 0.6;
    for (int d = 0; d + 1 < dim; ++d) inside &= x[d] > 0.8 && x[d] < 1.2;
    if (inside) sum += solver.points().m[p];
  }
  MPI_Allreduce(MPI_IN_PLACE, &sum, 1, MPI_DOUBLE, MPI_SUM, comm());
  return sum;
}

template <int dim>
void check_cage() {
  Json json = heap(dim);
  json["gauges"] = cage(dim);
  const auto solver = mpm_solver<dim>(json);
  const double start = mass_in_cage(*solver);
  double moved = 0;
  for (int n = 1; n <= 40; ++n) {
    take_steps(*solver, 0.005, n, 1);
    double out = 0;
    for (const auto& entry : json["gauges"]) {
      const double mass =
          probe(*solver, entry.at("name").template get<std::string>() + ".passed_mass");
      out += mass;
      moved += std::abs(mass);
    }
    EXPECT_NEAR(start - mass_in_cage(*solver), out, 1e-10 * start) << n;
  }
  EXPECT_GT(moved, 0.5 * start);
  EXPECT_GT(probe(*solver, "right.passed_mass"), 0.05 * start);
  EXPECT_LT(probe(*solver, "top.passed_mass"), -0.05 * start);
}

TEST(Gauges, what_passes_closed_gauges_is_what_is_missing_inside) {
  check_cage<2>();
  check_cage<3>();
}

/// Soil at rest under its weight: the pressure on a level gauge is that of the soil above it, on an
/// upright one K0 of it, but for the strain under that weight, 1e-6.
TEST(Gauges, pressure_at_rest) {
  Json json = heap(2);
  json["walls"] = {wall("bottom", "slip"), wall("left", "slip"), wall("right", "slip")};
  json["bodies"][0]["mesh"] = box({0, 0}, {2, 1}, {8, 4}, "quad4");
  json["bodies"][0]["velocity"] = {0, 0};
  json["bodies"][0]["initial_stress"] = {{"k0", 0.7}, {"surface", 1.0}};
  json["bodies"][0]["material"]["young_modulus"] = 1e9;
  json["gauges"] = {gauge("level", {{0.3, 0.5}, {1.7, 0.5}}), gauge("upright", {{1, 0}, {1, 2}})};
  const auto solver = make_mpm(json);
  EXPECT_NEAR(probe(*solver, "level.pressure"), 9810 * 0.5, 0.05);
  EXPECT_NEAR(probe(*solver, "upright.pressure"), 0.7 * 9810 * 0.5, 0.05);
  EXPECT_NEAR(probe(*solver, "upright.max_pressure"), 0.7 * 9810 * 0.9375, 0.05);
  EXPECT_NEAR(probe(*solver, "upright.depth"), 1, 1e-5);
  EXPECT_EQ(probe(*solver, "upright.speed"), 0);
}

TEST(Gauges, go_on_from_a_saved_state_to_the_bit) {
  Json json = heap(2);
  json["gauges"] = cage(2);
  const auto through = make_mpm(json), first = make_mpm(json), second = make_mpm(json);
  take_steps(*through, 0.005, 1, 30);
  take_steps(*first, 0.005, 1, 15);
  second->load_state(first->save_state());
  EXPECT_EQ(second->probes(), first->probes());
  take_steps(*second, 0.005, 16, 15);
  EXPECT_EQ(second->probes(), through->probes());
  EXPECT_NE(probe(*through, "right.passed_mass"), 0);
}

TEST(Gauges, corners_that_make_no_gauge_are_refused) {
  const auto refused = [](int dim, const std::vector<std::vector<double>>& corners,
                          const std::string& words) {
    Json json = heap(dim);
    json["gauges"] = {gauge("g", corners)};
    expect_error<ConfigError>([&] { make_mpm(json); }, {"/gauges/0/corners", words});
  };
  refused(2, {{1, 1}, {1, 1}}, "in one line");
  refused(2, {{1, 1}, {1, 2}, {2, 2}}, "found 3 points");
  refused(3, {{1, 1, 1}, {1, 1, 2}}, "found 2 points");
  refused(3, {{1, 1, 1}, {1, 1, 2}, {1, 1, 3}}, "in one line");
  Json json = heap(2);
  json["gauges"] = {gauge("g", {{1, 0}, {1, 1}}), gauge("g", {{1, 0}, {1, 1}})};
  expect_error<ConfigError>([&] { make_mpm(json); }, {"/gauges/1/name", "a second time"});
}

}  // namespace
}  // namespace gabion::test::test_gauges
