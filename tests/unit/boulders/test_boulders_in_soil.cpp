// SPDX-License-Identifier: BSD-3-Clause
// Boulders and soil push each other.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "common/mechanics/ranks/sum.hpp"
#include "solver_program/ranked_state.hpp"
#include "tests/support/expect_error.hpp"
#include "tests/unit/mpm/mpm_scene.hpp"

namespace gabion::test::test_boulders_in_soil {
namespace {

constexpr double g = 9.81, radius = 0.25, density = 2650;

double mass_of_sphere(int dim) {
  const double content = dim == 2 ? radius * radius : 4. / 3 * std::pow(radius, 3);
  return M_PI * density * content;
}

std::vector<double> at(int dim, double along, double up) {
  return dim == 2 ? std::vector<double>{along, up} : std::vector<double>{along, 0.5, up};
}

Json stone(int dim, double along, double up, double velocity_up) {
  std::vector<double> velocity(dim, 0.0);
  velocity[dim - 1] = velocity_up;
  return {{"name", "stone"},
          {"shape", {{"radius", radius}}},
          {"density", density},
          {"centre", at(dim, along, up)},
          {"velocity", velocity}};
}

/// Soil up to the height 0.4 m, and a stone that is just in contact with it.
Json bed(int dim, bool in_substeps) {
  const bool plane = dim == 2;
  const int cells = plane ? 10 : 8;
  std::vector<double> gravity(dim, 0.0);
  gravity[dim - 1] = -g;
  Json json = {{"dimension", dim},
               {"grid", plane ? box({-0.2, -0.2}, {1.2, 1.2}, {14, 14}, "quad4")
                              : box({-0.15, -0.15, -0.15}, {1.2, 1.2, 1.2}, {9, 9, 9}, "hex8")},
               {"basis", "linear"},
               {"walls", Json::array()},
               {"gravity", gravity},
               {"bodies",
                {body("soil",
                      plane ? box({0, 0}, {1, 0.4}, {cells, 4}, "quad4")
                            : box({0.15, 0.15, 0}, {0.9, 0.9, 0.45}, {5, 5, 3}, "hex8"),
                      plane ? 4 : 8, elastic_soil("neo_hookean", 1e6, 0.3, 1800))}},
               {"boulders", {stone(dim, 0.45, (plane ? 0.4 : 0.45) + radius + 0.001, -1)}}};
  if (!plane) json["boulders"][0]["shape"]["radius"] = radius;
  if (in_substeps) {
    json["time_integration"] = {{"scheme", "explicit"}};
  } else {
    json["newton"] = exact_newton;
  }
  return json;
}

double sum_of_momentum(const Solver& solver, const std::string& axis, double mass) {
  return probe(solver, "momentum_" + axis) + mass * probe(solver, "stone.v" + axis);
}

TEST(BouldersInSoil, momentum_is_that_of_gravity_alone) {
  for (const int dim : {2, 3}) {
    for (const bool in_substeps : {true, false}) {
      const auto solver = make_mpm(bed(dim, in_substeps));
      const std::string up = dim == 2 ? "y" : "z";
      const double mass = mass_of_sphere(dim), soil = probe(*solver, "mass");
      const double start = sum_of_momentum(*solver, up, mass);
      EXPECT_NEAR(start, -mass, 1e-12 * mass);
      const double dt = 1e-3;
      const int count = dim == 2 ? 60 : 20;
      run_steps(*solver, dt, count);
      const double expected = start - g * (mass + soil) * count * dt;
      EXPECT_NEAR(sum_of_momentum(*solver, up, mass), expected, (in_substeps ? 1e-12 : 1e-9) * mass)
          << dim << in_substeps;
      EXPECT_GT(probe(*solver, "stone.v" + up), -1 - 0.8 * g * count * dt) << dim << in_substeps;
      EXPECT_NEAR(sum_of_momentum(*solver, "x", mass), 0, (in_substeps ? 1e-12 : 1e-9) * mass);
    }
  }
}

/// Energy of soil and stone, with what contact stores [J].
double energy(const Solver& solver, double mass) {
  return probe(solver, "kinetic_energy") + probe(solver, "elastic_energy") +
         probe(solver, "contact_energy") - probe(solver, "gravity_work") +
         probe(solver, "stone.kinetic_energy") + mass * g * probe(solver, "stone.y");
}

TEST(BouldersInSoil, energy_is_not_gained) {
  for (const bool in_substeps : {true, false}) {
    const auto solver = make_mpm(bed(2, in_substeps));
    const double mass = mass_of_sphere(2), start = energy(*solver, mass);
    double last = start;
    for (int k = 0; k < 12; ++k) {
      run_steps(*solver, 1e-3, 10, 10 * k + 1);
      const double now = energy(*solver, mass);
      EXPECT_LT(now, last + 1e-3 * 0.5 * mass) << k << in_substeps;
      last = now;
    }
    EXPECT_GT(last, start - 0.5 * mass);
  }
}

/// The soil's force on the stone is its weight, once soil and stone are at rest.
TEST(BouldersInSoil, a_stone_rests_on_soil) {
  for (const bool in_substeps : {true, false}) {
    Json json = bed(2, in_substeps);
    json["grid"] = box({0, 0}, {1, 1.2}, {10, 12}, "quad4");
    json["walls"] = {wall("bottom", "fixed"), wall("left", "slip"), wall("right", "slip")};
    json["bodies"][0]["material"] = elastic_soil("mohr_coulomb", 1e6, 0.3, 1800);
    json["bodies"][0]["material"]["friction_angle"] = 35;
    json["boulders"][0]["velocity"] = {0, 0};
    json["boulders"][0]["centre"] = {0.5, 0.4 + radius};
    const auto solver = make_mpm(json);
    const double weight = g * mass_of_sphere(2), dt = 2e-3;
    run_steps(*solver, dt, 600);
    double force = 0, speed = 0;
    const int count = 500;
    for (int k = 1; k <= count; ++k) {
      run_steps(*solver, dt, 1, 600 + k);
      force += probe(*solver, "stone.fy") / count;
      speed = std::max(speed, std::abs(probe(*solver, "stone.vy")));
    }
    EXPECT_NEAR(force, weight, 0.01 * weight);
    EXPECT_LT(speed, 0.1);  // it swung by 0.5 m/s
    EXPECT_LT(std::abs(probe(*solver, "stone.vx")), 1e-6);
    EXPECT_NEAR(probe(*solver, "stone.x"), 0.5, 1e-6);
  }
}

/// A stone that soil carries into a gate: the gate's force is that of both.
Json carried(bool in_substeps) {
  Json json = bed(2, in_substeps);
  json["grid"] = box({0, 0}, {2, 1.2}, {20, 12}, "quad4");
  json["walls"] = {wall("bottom", "slip")};
  json["bodies"][0]["velocity"] = {3, 0};
  json["bodies"][0]["material"] = elastic_soil("mohr_coulomb", 1e6, 0.3, 1800);
  json["bodies"][0]["material"]["friction_angle"] = 30;
  json["boulders"][0]["velocity"] = {3, 0};
  json["boulders"][0]["centre"] = {0.8, 0.4 + radius};
  json["rigid_walls"] = {{{"name", "gate"},
                          {"surface", {{"polyline", {{1.1, 1.1}, {1.1, 0}}}, {"spacing", 0.1}}},
                          {"friction", 0.4}}};
  return json;
}

TEST(BouldersInSoil, a_gate_takes_the_momentum_of_both) {
  for (const bool in_substeps : {true, false}) {
    const auto solver = make_mpm(carried(in_substeps));
    const double mass = mass_of_sphere(2), dt = 5e-4;
    double before = sum_of_momentum(*solver, "x", mass);
    const double start = before;
    EXPECT_NEAR(start, 3 * (mass + probe(*solver, "mass")), 1e-9 * start);
    double hardest = 0;
    for (int n = 1; n <= 160; ++n) {
      run_steps(*solver, dt, 1, n);
      const double after = sum_of_momentum(*solver, "x", mass);
      const double force = probe(*solver, "gate.fx");
      EXPECT_NEAR(after - before, -dt * force, (in_substeps ? 1e-11 : 1e-7) * start) << n;
      hardest = std::max(hardest, force);
      before = after;
    }
    EXPECT_LT(before, 0.8 * start);
    EXPECT_LT(probe(*solver, "stone.vx"), 0.5);  // it hit the gate
    EXPECT_GT(hardest, 0);
    EXPECT_LT(probe(*solver, "stone.hard_contact_work"), 0);
  }
}

/// The columns of all boulders: energy by its works, momentum by the forces.
TEST(BouldersInSoil, energy_and_momentum_of_boulders_are_accounted_for) {
  for (const bool in_substeps : {true, false}) {
    const auto solver = make_mpm(carried(in_substeps));
    const double mass = mass_of_sphere(2), dt = in_substeps ? 1e-3 : 5e-4;
    const double start = probe(*solver, "boulders_kinetic_energy");
    EXPECT_NEAR(start, probe(*solver, "stone.kinetic_energy"), 1e-9);
    for (int k = 1; k <= 100; ++k) {
      const double before = probe(*solver, "boulders_momentum_x");
      run_steps(*solver, dt, 1, k);
      const double change = (probe(*solver, "boulders_momentum_x") - before) / dt;
      EXPECT_NEAR(change, probe(*solver, "stone.fx") - probe(*solver, "gate.boulders_fx"),
                  1e-7 * mass * g);
    }
    EXPECT_NEAR(probe(*solver, "boulders_momentum_x"), mass * probe(*solver, "stone.vx"), 1e-9);
    const double works =
        probe(*solver, "boulders_gravity_work") + probe(*solver, "boulders_soil_work") -
        probe(*solver, "boulders_surface_work") - probe(*solver, "boulders_contact_loss") -
        probe(*solver, "boulder_contact_energy");
    EXPECT_NEAR(probe(*solver, "boulders_kinetic_energy") - start, works, 1e-9 * start);
    EXPECT_EQ(probe(*solver, "boulders_surface_work"), 0);
    EXPECT_GT(probe(*solver, "boulders_contact_loss"), 0);
  }
}

/// The scene of carried() with two ellipses that touch each other, soil and the gate.
Json carried_ellipses(bool in_substeps) {
  Json json = carried(in_substeps);
  json["boulders"][0]["shape"] = {{"ellipsoid", {0.28, 0.18}}};
  json["boulders"][0]["orientation"] = {0.4};
  json["boulders"][0]["centre"] = {0.8, 0.66};
  json["boulders"][0]["spin"] = {-4};
  json["boulders"][0]["stiffness"] = 3e8;
  json["boulders"].push_back(json["boulders"][0]);
  json["boulders"][1]["name"] = "other";
  json["boulders"][1]["shape"]["ellipsoid"] = {0.15, 0.25};
  json["boulders"][1]["centre"] = {0.35, 0.67};
  return json;
}

TEST(BouldersInSoil, a_run_goes_on_with_the_same_bits) {
  for (const bool in_substeps : {true, false}) {
    for (const bool ellipses : {false, true}) {
      Json json = ellipses ? carried_ellipses(in_substeps) : carried(in_substeps);
      if (!in_substeps) json["linear_solver"] = {{"method", "gmres"}};
      const auto straight = mpm_solver<2>(json), first = mpm_solver<2>(json),
                 second = mpm_solver<2>(json);
      const double dt = 1e-3;
      run_steps(*straight, dt, 60);
      run_steps(*first, dt, 30);
      const State saved = gather_state(comm(), first->save_state());
      load_gathered(comm(), saved, *second);
      EXPECT_EQ(second->probes(), first->probes());
      if (ellipses) {
        EXPECT_GT(probe(*first, "boulder_contact_energy"), 0);
      }
      run_steps(*second, dt, 30, 31);
      EXPECT_TRUE(same_bits<2>(second->points(), straight->points()));
      EXPECT_EQ(second->probes(), straight->probes());
    }
  }
}

TEST(BouldersInSoil, ranks_agree) {
  for (const Json& json : {carried(true), carried_ellipses(true)}) {
    const auto shared = make_mpm(json), alone = make_mpm(json, MPI_COMM_SELF);
    run_steps(*shared, 1e-3, 60);
    run_steps(*alone, 1e-3, 60);
    for (const char* part : {"x", "y", "vx", "vy", "wz"}) {
      const std::string name = std::string("stone.") + part;
      EXPECT_NEAR(probe(*shared, name), probe(*alone, name), 1e-8) << name;
      double all = probe(*shared, name);
      MPI_Bcast(&all, 1, MPI_DOUBLE, 0, comm());
      EXPECT_EQ(all, probe(*shared, name)) << name;  // every rank has the same bits
    }
  }
}

/// A disc rolls on a slope that soil does not reach.
TEST(BouldersInSoil, a_disc_rolls_down_a_slope_by_its_inertia) {
  Json json = bed(2, true);
  json["grid"] = box({0, 0}, {4, 3}, {20, 15}, "quad4");
  json["bodies"][0]["mesh"] = box({0, 0}, {0.4, 0.4}, {4, 4}, "quad4");
  json["walls"] = {wall("bottom", "fixed")};
  const double angle = M_PI / 6, t = 0.5;
  json["rigid_walls"] = {
      {{"name", "slope"},
       {"surface", {{"polyline", {{3.8, 0.5}, {3.8 - 3 * std::cos(angle), 2}}}, {"spacing", 0.2}}},
       {"friction", 0.5}}};
  json["boulders"][0]["shape"] = {{"radius", 0.32}};
  json["boulders"][0]["velocity"] = {0, 0};
  const double x = 3.8 - 2.5 * std::cos(angle), y = 0.5 + 2.5 * std::sin(angle);
  json["boulders"][0]["centre"] = {x + 0.32 * std::sin(angle), y + 0.32 * std::cos(angle)};
  const auto solver = make_mpm(json);
  run_steps(*solver, 2e-3, static_cast<int>(t / 2e-3 + 0.5));
  const double speed = std::hypot(probe(*solver, "stone.vx"), probe(*solver, "stone.vy"));
  EXPECT_NEAR(speed, 2. / 3 * g * std::sin(angle) * t, 0.01);
  EXPECT_NEAR(-probe(*solver, "stone.wz") * 0.32, speed, 0.01);
  EXPECT_LT(probe(*solver, "slope.fy"), 0);
}

/// The momentum that a structure receives is what the stone loses.
TEST(BouldersInSoil, a_plate_gets_the_force_of_a_stone) {
  Json json = bed(2, true);
  json["grid"] = box({0, 0}, {2, 1.2}, {20, 12}, "quad4");
  json["walls"] = {wall("bottom", "fixed")};
  json["bodies"][0]["mesh"] = box({0, 0}, {0.4, 0.4}, {4, 4}, "quad4");
  json["interfaces"] = {
      {{"name", "plate"}, {"surface", {{"polyline", {{1.8, 0.5}, {0.8, 0.5}}}, {"spacing", 0.1}}}}};
  json["boulders"][0]["centre"] = {1.33, 0.5 + radius + 0.002};
  json["boulders"][0]["velocity"] = {0.5, -2};
  json["boulders"][0]["spin"] = {4};
  const auto solver = make_mpm(json);
  const double mass = mass_of_sphere(2), dt = 5e-4;
  std::vector<double> down(22, 0.0);
  double lost = 0;
  for (int n = 1; n <= 40; ++n) {
    for (std::size_t v = 0; v < down.size(); v += 2) down[v + 1] = -0.01 * n * dt;
    const double before = probe(*solver, "stone.vy");
    StepRequest request{n, 0, (n - 1) * dt, dt};
    InterfaceValues sent, again;
    solver->solve_step(request, {{"plate", down}}, sent);
    ++request.iteration;
    solver->solve_step(request, {{"plate", down}}, again);
    EXPECT_EQ(sent, again);
    solver->accept_step(request, true);
    double force = 0;
    for (std::size_t v = 0; v < down.size(); v += 2) force += again.at("plate")[v + 1];
    EXPECT_NEAR(mass * (probe(*solver, "stone.vy") - before), -dt * (mass * g + force),
                1e-10 * mass);
    lost -= dt * force;
  }
  EXPECT_GT(lost, 2 * mass);
}

/// A stone is held while the soil settles without inertia, and free in the phase after it.
TEST(BouldersInSoil, a_stone_is_held_until_it_is_free) {
  Json json = bed(2, false);
  json["grid"] = box({0, 0}, {1, 1.2}, {10, 12}, "quad4");
  json["walls"] = {wall("bottom", "fixed"), wall("left", "slip"), wall("right", "slip")};
  json["phases"] = {{{"analysis", "quasi_static"}, {"until", 0.01}}, {{"analysis", "dynamic"}}};
  json["boulders"][0]["free_from"] = 0.01;
  const auto solver = make_mpm(json);
  const double x = probe(*solver, "stone.x"), y = probe(*solver, "stone.y");
  run_steps(*solver, 1e-3, 10);
  EXPECT_EQ(probe(*solver, "stone.x"), x);
  EXPECT_EQ(probe(*solver, "stone.y"), y);
  EXPECT_EQ(probe(*solver, "stone.vy"), -1);
  run_steps(*solver, 1e-3, 5, 11);
  EXPECT_LT(probe(*solver, "stone.y"), y - 0.004);
}

TEST(BouldersInSoil, a_stone_that_falls_out_of_the_grid_is_refused) {
  Json json = bed(2, true);
  json["boulders"][0]["centre"] = {1.1, 0.2};
  json["boulders"][0]["velocity"] = {4, 0};
  json["bodies"][0]["mesh"] = box({0, 0}, {0.4, 0.4}, {4, 4}, "quad4");
  const auto solver = make_mpm(json);
  expect_error<ConvergenceError>([&] { run_steps(*solver, 1e-2, 10); },
                                 {"\"stone\"", "leave the background grid", "1.18", "rigid_walls"});
  json["outside"] = "remove";
  const auto other = make_mpm(json);
  run_steps(*other, 1e-2, 10);
  EXPECT_GT(probe(*other, "stone.x"), 1.3);
}

/// A step in which the soil is much stiffer than the stone is heavy either agrees with a finer one
/// or is an error.
TEST(BouldersInSoil, light_stones_on_stiff_soil_agree_or_are_refused) {
  for (const double light : {1000., 300., 100., 30.}) {
    Json json = bed(2, false);
    json["boulders"][0]["density"] = light;
    json["bodies"][0]["material"]["young_modulus"] = 1e8;
    const auto solver = make_mpm(json);
    const double mass = M_PI * radius * radius * light, soil = probe(*solver, "mass"), dt = 5e-3;
    try {
      run_steps(*solver, dt, 8);
    } catch (const ConvergenceError& error) {
      EXPECT_NE(std::string(error.what()).find("too light"), std::string::npos) << error.what();
      continue;
    }
    EXPECT_NEAR(sum_of_momentum(*solver, "y", mass), -mass - g * (mass + soil) * 8 * dt,
                1e-9 * (mass + soil));
  }
}

void expect_refused(const Json& json, const std::vector<std::string_view>& parts) {
  expect_error<ConfigError>([&] { make_mpm(json); }, parts);
}

TEST(BouldersInSoil, bad_input) {
  const auto with = [](const std::string& key, const Json& value) {
    Json json = carried(true);
    json["boulders"][0][key] = value;
    return json;
  };
  expect_refused(with("shape", {{"radius", 0.1}}), {"/boulders/0/shape", "0.2 m", "0.3 m"});
  expect_refused(with("shape", {{"radius", -1}}), {"/boulders/0/shape/radius", "-1"});
  expect_refused(with("shape", {{"radius", 0.3}, {"box", {1, 1}}}),
                 {"/boulders/0/shape/box", "one of"});
  expect_refused(with("shape", Json::object()), {"/boulders/0/shape"});
  expect_refused(with("shape", {{"box", {1, 1, 1}}}), {"/boulders/0/shape/box", "2 numbers"});
  expect_refused(with("shape", {{"ellipsoid", {0.3, 0.2, 0.2}}}),
                 {"/boulders/0/shape/ellipsoid", "2 numbers"});
  expect_refused(with("shape", {{"ellipsoid", {0.3}}}),
                 {"/boulders/0/shape/ellipsoid", "2 numbers"});
  expect_refused(with("shape", {{"ellipsoid", {0.3, 0}}}), {"/boulders/0/shape/ellipsoid", "0"});
  expect_refused(with("shape", {{"ellipsoid", {-0.3, 0.3}}}),
                 {"/boulders/0/shape/ellipsoid", "-0.3"});
  expect_refused(with("shape", {{"ellipsoid", {0.3, "nan"}}}), {"/boulders/0/shape/ellipsoid"});
  expect_refused(with("shape", {{"ellipsoid", {0.3, 0.1}}}), {"/boulders/0/shape", "0.1", "0.3 m"});
  expect_refused(with("shape", {{"triangles", "a.stl"}}),
                 {"/boulders/0/shape/triangles", "polygon"});
  expect_refused(with("shape", {{"polygon", {{0, 0}, {0, 1}, {1, 0}}}}),
                 {"/boulders/0/shape/polygon", "volume"});
  expect_refused(with("density", 0), {"/boulders/0/density"});
  expect_refused(with("restitution", 1.5), {"/boulders/0/restitution", "1.5"});
  expect_refused(with("name", "gate"), {"/boulders/0/name", "gate"});
  expect_refused(with("centre", {1.0, 0.7}), {"/boulders/0/centre", "stone", "gate", "0.15 m"});
  expect_refused(with("centre", {1.25, 0.7}), {"/boulders/0/centre", "stone", "gate", "0.4 m"});
  expect_refused(with("colour", 1), {"/boulders/0/colour", "unknown"});
  expect_refused(with("centre", {0.5, 0.4}), {"/boulders/0/shape", "inside"});
  Json twice = carried(true);
  twice["boulders"].push_back(twice["boulders"][0]);
  expect_refused(twice, {"/boulders/1/name", "stone", "second time"});
  twice["boulders"][1]["name"] = "other";
  twice["boulders"][1]["centre"] = {0.5, 0.7};
  expect_refused(twice, {"/boulders/0/centre", "stone", "other"});
  Json still = bed(2, false);
  still["analysis"] = "quasi_static";
  expect_refused(still, {"/boulders/0/free_from"});
}

}  // namespace
}  // namespace gabion::test::test_boulders_in_soil
