// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>

#include "tests/support/expect_error.hpp"
#include "tests/unit/fem/beam_scene.hpp"

namespace gabion::test::test_beam_structure {
namespace {

using std::numbers::pi;
using Parts = std::vector<std::string_view>;

constexpr double E = 2e8, h = 0.1, b = 0.05, L = 2;
constexpr double EI = E * b * h * h * h / 12;

Json material(int dimension) {
  Json json = beam_material(E, 0.25, rectangle(h, b), 1000);
  if (dimension == 3) json["orientation"] = {0, 1, 0};
  return json;
}

Json vector(int dimension, double x, double y) {
  return dimension == 2 ? Json{x, y} : Json{x, y, 0.0};
}

/// Force and moments of a short cantilever: reactions, resultants, energy and the tip of
/// Timoshenko's beam.
void expect_cantilever(int dimension, Solver& solver) {
  constexpr double P = 0.1;
  for (int n = 1; n <= 2; ++n) advance(solver, n, 0.5);
  EXPECT_NEAR(probe(solver, "reaction_low_y"), -P, 1e-9);
  EXPECT_NEAR(probe(solver, "moment_low_z"), -P * L, 1e-6);
  EXPECT_NEAR(probe(solver, "bending_max_rope"), P * L, 1e-6);
  EXPECT_NEAR(probe(solver, "shear_max_rope"), P, 1e-7);
  EXPECT_NEAR(probe(solver, "torsion_max_rope"), 0, 1e-9) << dimension;
  EXPECT_NEAR(probe(solver, "at_half.M_z"), P * L / 2, 1e-6);
  EXPECT_NEAR(probe(solver, "at_half.V_y"), P, 1e-9);
  const double GA = E / 2.5 * 10 * 1.25 / (12 + 11 * 0.25) * h * b;
  const double tip = P * L * L * L / (3 * EI) * (1 - 1 / (4.0 * 64)) + P * L / GA;  // 8 cells
  EXPECT_NEAR(probe(solver, "tip.uy"), tip, 1e-5 * tip);
  EXPECT_NEAR(probe(solver, "elastic_energy"), 0.5 * P * tip, 1e-5 * P * tip);
}

template <int dim>
void cantilever() {
  const TemporaryMesh mesh(chain(L, 8).file());
  Json json = cantilever_of_beams(dim, mesh.path(), material(dim), L);
  json["loads"] = {rising_load(vector(dim, 0, 0.1))};
  json["sections"] = {
      {{"name", "at_half"}, {"point", vector(dim, L / 2, 0)}, {"normal", vector(dim, 1, 0)}}};
  const auto solver = fem_solver<dim>(json);
  EXPECT_EQ(solver->summary().at("nodes"), 9);
  EXPECT_EQ(solver->summary().at("unknowns"), dim == 2 ? 24 : 48);
  expect_cantilever(dim, *solver);
}

TEST(BeamStructure, cantilever_in_the_plane_and_in_space) {
  cantilever<2>();
  cantilever<3>();
}

/// A plane through the middle of a beam counts it as in front, whatever rounding says.
TEST(BeamStructure, plane_through_the_middle_of_a_beam) {
  const TemporaryMesh mesh(chain(L, 7).file());
  const auto shear = [&](double place) {
    Json json = cantilever_of_beams(2, mesh.path(), material(2), L);
    json["gravity"] = {0, -0.1};  // the weight of half a beam at the cut is in the force
    json["sections"] = {
        {{"name", "cut"}, {"point", vector(2, place, 0)}, {"normal", vector(2, 1, 0)}}};
    const auto solver = fem_solver<2>(json);
    advance(*solver, 1, 1);
    return probe(*solver, "cut.V_y");
  };
  const double weight = 1000 * h * b * L / 7 * 0.1, above = shear(L / 2 * (1 + 1e-14));
  EXPECT_NEAR(shear(L / 2 * (1 - 1e-14)), above, 1e-9 * weight);
  EXPECT_NEAR(std::abs(shear(L / 2 * 1.01) - above), weight, 1e-6 * weight);
}

/// A moment of 2 pi E I / L bends any number of cells into a closed polygon.
TEST(BeamStructure, rolls_into_a_circle) {
  for (const int dim : {2, 3}) {
    const TemporaryMesh mesh(chain(L, 5).file());
    Json json = cantilever_of_beams(dim, mesh.path(), material(dim), L);
    Json load = rising_load(vector(dim, 0, 0));
    const double M = 2 * pi * EI / L;
    load["moment"] = dim == 2 ? Json{M} : Json{0.0, 0.0, M};
    json["loads"] = {load};
    json["newton"] = {{"residual_tolerance", 1e-12}};
    const auto run = [&](Solver& solver) {
      for (int n = 1; n <= 40; ++n) advance(solver, n, 0.025);
      EXPECT_NEAR(probe(solver, "tip.ux"), -L, 1e-9);
      EXPECT_NEAR(probe(solver, "tip.uy"), 0, 1e-9);
      EXPECT_NEAR(probe(solver, "bending_max_rope"), M, 1e-9 * M);
      EXPECT_NEAR(probe(solver, "moment_low_z"), -M, 1e-9 * M);
      EXPECT_NEAR(probe(solver, "elastic_energy"), 0.5 * M * 2 * pi, 1e-9 * M);
    };
    if (dim == 2) {
      run(*fem_solver<2>(json));
    } else {
      run(*fem_solver<3>(json));
    }
  }
}

/// A cantilever that swings through large angles in the plane x y, in the plane or in space.
Json swing(int dimension, const std::string& file) {
  Json json = cantilever_of_beams(dimension, file, material(dimension), L, "dynamic");
  json["loads"] = {rising_load(vector(dimension, 0, 900))};
  json["newton"] = {{"residual_tolerance", 1e-11}};
  return json;
}

/// Rotations about one axis add up: space gives what the plane gives.
TEST(BeamStructure, space_as_the_plane) {
  const TemporaryMesh mesh(chain(L, 6).file());
  const auto plane = fem_solver<2>(swing(2, mesh.path()));
  const auto space = fem_solver<3>(swing(3, mesh.path()));
  for (int n = 1; n <= 40; ++n) {
    advance(*plane, n, 0.02);
    advance(*space, n, 0.02);
    for (const char* name : {"tip.ux", "tip.uy", "kinetic_energy", "bending_max_rope"}) {
      const double x = probe(*plane, name);
      EXPECT_NEAR(probe(*space, name), x, 1e-7 * (1 + std::abs(x))) << n << name;
    }
  }
  EXPECT_GT(probe(*plane, "tip.uy"), 0.5 * L);
}

/// Work of the loads less the energies, of the largest energy.
double lost_energy(double dt) {
  const TemporaryMesh mesh(chain(L, 6).file());
  Json json = swing(3, mesh.path());
  json["loads"].push_back(rising_load(Json{0, 0, 200}));
  const auto solver = fem_solver<3>(json);
  double worst = 0, largest = 0;
  for (int n = 1; n * dt <= 1 + 1e-9; ++n) {
    advance(*solver, n, dt);
    const double stored = probe(*solver, "kinetic_energy") + probe(*solver, "elastic_energy");
    largest = std::max(largest, stored);
    worst = std::max(worst, std::abs(probe(*solver, "external_work") - stored));
  }
  return worst / largest;
}

/// The trapezoidal rule keeps the energy of beams that turn to second order in the step.
TEST(BeamStructure, energy_in_dynamics) {
  const double coarse = lost_energy(0.01), fine = lost_energy(0.005);
  EXPECT_LT(coarse, 0.01);
  EXPECT_GT(std::log2(coarse / fine), 1.7);
}

/// Loads one after the other or both at once lead to the same state: no path in elastic beams. The
/// load in the stiff plane is below the 219 N at which the cantilever buckles sideways.
TEST(BeamStructure, path_independent) {
  const TemporaryMesh mesh(chain(L, 6).file());
  Json json = cantilever_of_beams(3, mesh.path(), material(3), L);
  const auto load = [](const Json& force, const Json& table) {
    return Json{{"group", "high"}, {"force", force}, {"table", table}};
  };
  const auto run = [&](const Json& first, const Json& second) {
    json["loads"] = {load({0, 150, 0}, first), load({-50, 0, 150}, second)};
    const auto solver = fem_solver<3>(json);
    for (int n = 1; n <= 80; ++n) advance(*solver, n, 0.025);
    return std::vector{probe(*solver, "tip.ux"), probe(*solver, "tip.uy"), probe(*solver, "tip.uz"),
                       probe(*solver, "elastic_energy")};
  };
  const Json early = {{0, 0}, {1, 1}}, late = {{1, 0}, {2, 1}}, slow = {{0, 0}, {2, 1}};
  const auto one = run(early, late), other = run(late, early), both = run(slow, slow);
  EXPECT_GT(std::abs(one[2]), 0.1);
  for (int k = 0; k < 4; ++k) {
    EXPECT_NEAR(one[k], other[k], 1e-7 * std::abs(one[k])) << k;
    EXPECT_NEAR(one[k], both[k], 1e-7 * std::abs(one[k])) << k;
  }
}

/// States of rest in which the structure would not stay, under a share of Euler's load.
template <int dim>
int unstable_columns(double share) {
  const TemporaryMesh mesh(chain(L, 8).file());
  const double I = dim == 2 ? b * h * h * h / 12 : h * b * b * b / 12;  // of the weak axis
  const double P = pi * pi * E * I / (4 * L * L);
  Json json = cantilever_of_beams(dim, mesh.path(), material(dim), L);
  json["loads"] = {rising_load(vector(dim, -share * P, 0))};
  const auto solver = fem_solver<dim>(json);
  for (int n = 1; n <= 2; ++n) advance(*solver, n, 0.5);
  return solver->summary().at("unstable_equilibria");
}

TEST(BeamStructure, statics_count_states_beyond_buckling) {
  EXPECT_EQ(unstable_columns<2>(0.95), 0);
  EXPECT_EQ(unstable_columns<2>(1.05), 1);
  EXPECT_EQ(unstable_columns<3>(0.95), 0);
  EXPECT_EQ(unstable_columns<3>(1.05), 1);
}

TEST(BeamStructure, restart_gives_the_same_bits) {
  const TemporaryMesh mesh(chain(L, 6).file());
  Json json = swing(3, mesh.path());
  json["loads"].push_back(rising_load(Json{0, 0, 200}));
  const auto run = fem_solver<3>(json), restarted = fem_solver<3>(json);
  for (int n = 1; n <= 10; ++n) advance(*run, n, 0.02);
  restarted->load_state(run->save_state());
  EXPECT_EQ(restarted->probes(), run->probes());
  for (int n = 11; n <= 20; ++n) {
    advance(*run, n, 0.02);
    advance(*restarted, n, 0.02);
    EXPECT_EQ(restarted->probes(), run->probes()) << n;
  }
  EXPECT_EQ(restarted->save_state().reals, run->save_state().reals);
}

/// Weight at the supports, and no momentum of rotations.
TEST(BeamStructure, weight_and_momentum) {
  const TemporaryMesh mesh(chain(L, 4).file());
  Json json = cantilever_of_beams(3, mesh.path(), material(3), L);
  json["gravity"] = {0, -10, 0};
  const auto still = fem_solver<3>(json);
  advance(*still, 1, 1);
  EXPECT_NEAR(probe(*still, "reaction_low_y"), 1000 * h * b * L * 10, 1e-6);
  EXPECT_NEAR(probe(*still, "moment_low_z"), 1000 * h * b * L * 10 * L / 2, 0.5);
  json = cantilever_of_beams(3, mesh.path(), material(3), L, "dynamic");
  json.erase("supports");
  json["initial_velocity"] = {1, 2, 3};
  const auto flying = fem_solver<3>(json);
  advance(*flying, 1, 1);
  EXPECT_NEAR(probe(*flying, "momentum_z"), 1000 * h * b * L * 3, 1e-9);
  EXPECT_NEAR(probe(*flying, "kinetic_energy"), 0.5 * 1000 * h * b * L * 14, 1e-9);
  EXPECT_NEAR(probe(*flying, "tip.uz"), 3, 1e-9);
}

void expect_refused(int dimension, const std::function<void(Json&)>& change, const Parts& parts) {
  const TemporaryMesh mesh(chain(L, 4).file());
  Json json = cantilever_of_beams(dimension, mesh.path(), material(dimension), L);
  change(json);
  if (dimension == 2) {
    expect_error<ConfigError>([&] { fem_solver<2>(json); }, parts);
  } else {
    expect_error<ConfigError>([&] { fem_solver<3>(json); }, parts);
  }
}

void expect_section_refused(const Json& section, const Parts& parts) {
  expect_refused(
      2, [&](Json& json) { json["materials"][0]["cross_section"] = section; }, parts);
}

TEST(BeamErrors, sections) {
  expect_refused(2, [](Json& json) { json["materials"][0].erase("cross_section"); },
                 {"/materials/0", "cross_section"});
  expect_section_refused({{"shape", "rectangle"}, {"height", 0}, {"width", 1}},
                         {"/materials/0/cross_section/height", "0"});
  expect_section_refused({{"shape", "pipe"}, {"diameter", 0.2}, {"wall", 0.1}},
                         {"/materials/0/cross_section/wall", "0.1", "less than half"});
  expect_section_refused({{"shape", "circle"}, {"height", 0.2}}, {"/materials/0/cross_section"});
  Json general = general_section(1, 1, 1);
  general["area"] = 0;
  expect_section_refused(general, {"/materials/0/cross_section/area", "0"});
  general["area"] = 1;
  general["second_moments"] = {1, 0};
  expect_section_refused(general, {"/materials/0/cross_section/second_moments", "0"});
  expect_section_refused({{"shape", "star"}}, {"/materials/0/cross_section/shape", "pipe"});
}

TEST(BeamErrors, keys_of_beams) {
  expect_refused(3, [](Json& json) { json["materials"][0].erase("orientation"); },
                 {"/materials/0/orientation", "none", "not round"});
  expect_refused(3,
                 [](Json& json) {
                   json["materials"][0]["orientation"] = {2, 0, 0};
                 },
                 {"/materials/0/group", "orientation", "along a beam"});
  expect_refused(2,
                 [](Json& json) {
                   json["materials"][0]["orientation"] = {0, 1, 0};
                 },
                 {"/materials/0/orientation", "3D"});
  expect_refused(3, [](Json& json) { json["materials"][0]["spacing"] = 2; },
                 {"/materials/0/spacing", "2D"});
  expect_refused(2, [](Json& json) { json["materials"][0]["pretension"] = 1; },
                 {"/materials/0/pretension"});
  expect_refused(2, [](Json& json) { json["materials"][0].erase("poisson_ratio"); },
                 {"/materials/0", "poisson_ratio"});
}

TEST(BeamErrors, rotations_and_moments) {
  const auto truss = [](Json& json) {
    json["materials"][0] = line_material("truss", 1e9, 1);
    json["materials"][0]["group"] = "rope";
  };
  expect_refused(2, truss, {"/supports/0/group", "\"low\"", "no beam", "\"beam\""});
  expect_refused(2, [](Json& json) { json["supports"][0]["rotations"] = {"x"}; },
                 {"/supports/0/rotations/0", "\"x\"", "z"});
  expect_refused(3,
                 [](Json& json) {
                   json["supports"][0]["rotations"] = {"x", "x"};
                 },
                 {"/supports/0/rotations/1", "second time"});
  const auto moment = [&](Json& json) {
    truss(json);
    json["supports"][0].erase("rotations");
    Json load = rising_load({0, 0});
    load["moment"] = {1};
    json["loads"] = {load};
  };
  expect_refused(2, moment, {"/loads/0/group", "moment", "no beam"});
  expect_refused(2,
                 [](Json& json) {
                   Json load = rising_load({0, 0});
                   load["moment"] = {1, 2, 3};
                   json["loads"] = {load};
                 },
                 {"/loads/0/moment", "1"});
}

}  // namespace
}  // namespace gabion::test::test_beam_structure
