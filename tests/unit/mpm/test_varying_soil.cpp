// SPDX-License-Identifier: BSD-3-Clause
// Soil whose constants vary in space: the law of each point in steps, on ranks, after a restart.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "mpm_solver/parameters/point_laws.hpp"
#include "tests/support/expect_error.hpp"
#include "tests/unit/mpm/collapse.hpp"

namespace gabion::test::test_varying_soil {
namespace {

Json by_depth(const Json& rows, double below) {
  return {{"by_depth", rows}, {"below", below}};
}

/// One value at all depths.
Json everywhere(double value) {
  return by_depth({{-100, value}, {100, value}}, 0);
}

/// The scene with constants in the place of which there is what gives the same values.
Json with_equal_values(Json scene) {
  for (Json& body : scene["bodies"]) {
    Json& material = body["material"];
    for (const char* key : {"young_modulus", "friction_angle", "cohesion", "dilation_angle"}) {
      if (material.contains(key)) material[key] = everywhere(material[key].get<double>());
    }
  }
  return scene;
}

/// Strength and stiffness that grow with the depth below y = 1.
Json varying_scene(const Collapse& soil) {
  Json scene = collapse_scene(soil);
  for (Json& body : scene["bodies"]) {
    body["material"]["young_modulus"] = by_depth({{0, 1e5}, {1, 3e5}}, 1);
    if (soil.law != "mohr_coulomb") continue;
    body["material"]["friction_angle"] = by_depth({{0, 15}, {1, 25}}, 1);
    body["material"]["cohesion"] = {
        {"random",
         {{"mean", 300}, {"cov", 0.5}, {"correlation_lengths", {0.5, 0.2}}, {"seed", 3}}}};
  }
  return scene;
}

void expect_same_run(const Json& a, const Json& b, int steps) {
  const auto constant = mpm_solver<2>(a), varying = mpm_solver<2>(b);
  run_collapse(*constant, 1, steps);
  run_collapse(*varying, 1, steps);
  mpm::MaterialPoints<2> points = varying->points();
  EXPECT_FALSE(points.parameters.empty() && points.size() > 0);
  points.parameters.clear();
  EXPECT_TRUE(same_bits<2>(points, constant->points()));
  EXPECT_EQ(varying->probes(), constant->probes());
}

/// Points with equal values share a law and its batches, so nothing changes in any bit.
TEST(VaryingSoil, equal_values_give_the_same_bits) {
  if (size() > 1) return;  // there MUMPS adds in the order of messages
  for (const Collapse& soil : {Collapse{}, Collapse{.basis = "gimp", .locking = "fbar"},
                               Collapse{.cells = "tri3", .locking = "fbar"},
                               Collapse{.law = "neo_hookean"}, Collapse{.with_plate = true}}) {
    SCOPED_TRACE(soil.basis + " " + soil.cells + " " + soil.law);
    const Json scene = collapse_scene(soil);
    expect_same_run(scene, with_equal_values(scene), 15);
  }
  Json scene = collapse_scene({});
  scene["time_integration"] = {{"scheme", "explicit"}};
  scene["small_cuts"] = {{"method", "none"}};
  for (const char* key : {"newton", "linear_solver"}) scene.erase(key);
  expect_same_run(scene, with_equal_values(scene), 15);
}

/// Laws with memory and laws that see the size of the step.
TEST(VaryingSoil, equal_values_of_other_laws_give_the_same_bits) {
  if (size() > 1) return;
  Json softens = collapse_scene({}), flows = softens;
  for (int b : {0, 1}) {
    Json& soil = softens["bodies"][b]["material"];
    soil["cohesion"] = 500;
    soil["softening"] = {{"slip", 0.1}, {"residual_cohesion", 200}};
    Json& mud = flows["bodies"][b]["material"];
    mud = elastic_soil("herschel_bulkley", 2e5, 0.3, 1500);
    mud["yield_stress"] = 100;
    mud["consistency"] = 50;
  }
  expect_same_run(softens, with_equal_values(softens), 10);
  Json varying = with_equal_values(flows);
  for (Json& each : varying["bodies"]) {
    Json& mud = each["material"];
    for (const char* key : {"yield_stress", "consistency"}) {
      mud[key] = everywhere(mud[key].get<double>());
    }
  }
  expect_same_run(flows, varying, 10);
}

/// A body with layers is two bodies with a material each, on the same points. Batches have other
/// points, so sums are added in another order.
TEST(VaryingSoil, layers_are_bodies) {
  if (size() > 1) return;
  for (const char* basis : {"linear", "gimp"}) {
    Json scene = collapse_scene({.basis = basis});
    scene["quadrature"] = "points";  // which cells are full is found for each body
    Json& lower = scene["bodies"][0]["material"];
    const Json upper = lower;
    lower["cohesion"] = 500;
    lower["young_modulus"] = 4e5;
    const auto two = mpm_solver<2>(scene);
    Json one_scene = scene;
    one_scene["bodies"] = {
        body("soil", box({0, 0}, {0.6, 1.0}, {6, 10}, "quad4"), 4, upper, {1.5, 0})};
    one_scene["bodies"][0]["material"]["layers"] = {
        {{"below", 0.6}, {"cohesion", 500}, {"young_modulus", 4e5}}};
    const auto one = mpm_solver<2>(one_scene);
    run_collapse(*two, 1, 20);
    run_collapse(*one, 1, 20);
    const auto &a = one->points(), &b = two->points();
    ASSERT_EQ(a.size(), b.size());
    double largest = 0, yielded = 0;
    for (std::int32_t p = 0; p < a.size(); ++p) {
      // Points are numbered cell by cell; those of one place are found by it.
      const Vector<2> X = a.x[p] - a.u[p];
      for (std::int32_t q = 0; q < b.size(); ++q) {
        if ((b.x[q] - b.u[q] - X).norm() > 1e-6) continue;
        largest = std::max(largest, (a.x[p] - b.x[q]).norm());
        yielded = std::max(yielded, b.history[q].plastic_strain);
      }
    }
    EXPECT_LT(largest, 1e-8) << basis << " " << yielded;
    EXPECT_GT(yielded, 1e-3);
  }
}

/// Under its weight a column of layers settles by the sum of what each layer shortens. Nodes of
/// linear cells have the exact displacement where each cell has one stiffness.
TEST(VaryingSoil, column_of_layers_settles_by_the_integral) {
  constexpr double rho = 2000, g = 1e-4, E = 1e6;  // strains of 1e-7
  Json material = elastic_soil("linear_elastic", E, 0, rho);
  material["layers"] = {{{"below", 3}, {"young_modulus", 2 * E}},
                        {{"below", 1}, {"young_modulus", 5 * E}}};
  const Json scene = {
      {"dimension", 2},
      {"analysis", "quasi_static"},
      {"basis", "linear"},
      {"grid", box({0, 0}, {1, 5}, {1, 5}, "quad4")},
      {"small_cuts", {{"method", "none"}}},
      {"newton", exact_newton},
      {"gravity", {0, -g}},
      {"walls", {wall("bottom", "slip"), wall("left", "slip"), wall("right", "slip")}},
      {"bodies", {body("soil", box({0, 0}, {1, 4}, {1, 4}, "quad4"), 4, material)}}};
  const auto solver = mpm_solver<2>(scene);
  run_collapse(*solver, 1, 1);
  // u(y) = int_0^y rho g (4 - s) / E(s) ds at nodes, linear between them.
  const double at_nodes[] = {0, 3.5 / 5, 3.5 / 5 + 2.5 / 2, 3.5 / 5 + 4.0 / 2,
                             3.5 / 5 + 4.0 / 2 + 0.5};
  const auto& points = solver->points();
  for (std::int32_t p = 0; p < points.size(); ++p) {
    const double y = points.x[p][1] - points.u[p][1];
    const int cell = static_cast<int>(y);
    const double u = at_nodes[cell] + (y - cell) * (at_nodes[cell + 1] - at_nodes[cell]);
    EXPECT_NEAR(points.u[p][1] / (-rho * g / E), u, 1e-5 * u);
  }
}

/// On ranks the values are the same in every bit, and so is a run that goes on from a saved state.
TEST(VaryingSoil, restart_and_ranks) {
  constexpr int half = 12, all = 24;
  for (const Collapse& soil : {Collapse{}, Collapse{.basis = "gimp", .locking = "fbar"}}) {
    const Json json = varying_scene(soil);
    const auto alone = mpm_solver<2>(json, MPI_COMM_SELF), shared = mpm_solver<2>(json);
    run_collapse(*alone, 1, all);
    run_collapse(*shared, 1, all);
    expect_same_points<2>(shared->points(), alone->points(), 1e-8);
    const auto &a = shared->points(), &b = alone->points();
    ASSERT_EQ(a.parameters.size(), a.x.size());
    for (std::int32_t p = 0; p < a.size(); ++p) {  // every bit, wherever the point is
      EXPECT_EQ(a.parameters[p], b.parameters[mpm::find_point(b, a.id[p])]);
    }
    if (size() > 1) continue;
    const auto first = mpm_solver<2>(json), second = mpm_solver<2>(json);
    run_collapse(*first, 1, half);
    second->load_state(first->save_state());
    run_collapse(*second, half + 1, all);
    EXPECT_TRUE(same_bits<2>(second->points(), alone->points()));
  }
}

/// A state without the values, or one that has values where nothing varies, is refused.
TEST(VaryingSoil, states_of_other_scenes_are_refused) {
  if (size() > 1) return;
  const auto constant = mpm_solver<2>(collapse_scene({})),
             varying = mpm_solver<2>(varying_scene({}));
  expect_error<Error>([&] { varying->load_state(constant->save_state()); }, {"points.parameters"});
  const auto other = mpm_solver<2>(collapse_scene({}));
  expect_error<Error>([&] { other->load_state(mpm_solver<2>(varying_scene({}))->save_state()); },
                      {"points.parameters"});
}

/// Geostatic stress in soil whose stiffness grows with depth: in balance but for the strains.
TEST(VaryingSoil, initial_stress) {
  Json scene = collapse_scene({});
  scene["bodies"] = {scene["bodies"][0]};
  Json& soil = scene["bodies"][0];
  soil.erase("velocity");
  scene.erase("probes");
  scene["walls"] = {wall("bottom", "slip"), wall("left", "slip"), wall("right", "slip")};
  scene["grid"] = box({0, 0}, {0.6, 0.8}, {6, 8}, "quad4");
  soil["material"]["young_modulus"] = by_depth({{0, 2e7}, {1, 8e7}}, 0.6);
  soil["material"]["friction_angle"] = by_depth({{0, 30}, {1, 35}}, 0.6);
  soil["initial_stress"] = {{"k0", 0.5}, {"surface", 0.6}, {"max_displacement", 1e-5}};
  const auto solver = mpm_solver<2>(scene);
  const auto& points = solver->points();
  for (std::int32_t p = 0; p < points.size(); ++p) {
    const double depth = 0.6 - points.x[p][1], load = 1500 * 9.81 * depth;
    EXPECT_NEAR(points.tau[p][1], -load, 1e-3 * load);
    EXPECT_NEAR(points.tau[p][0], -0.5 * load, 1e-3 * load);
    // e of Hooke's law with the modulus of the point, in Hencky strains.
    const double E = 2e7 + 6e7 * depth;
    const double strain = (points.tau[p][1] - 0.3 * (points.tau[p][0] + points.tau[p][2])) / E;
    EXPECT_NEAR(0.5 * std::log1p(points.history[p].e[1]), strain, 1e-2 * std::abs(strain));
  }
  soil["initial_stress"]["k0"] = "jaky";
  expect_error<ConfigError>([&] { make_mpm(scene); },
                            {"/initial_stress/k0", "friction_angle that varies"});
}

/// Steps without a limit are as short as the stiffest point wants.
TEST(VaryingSoil, the_stiffest_point_is_the_body) {
  const auto settings = mpm_settings<2>(varying_scene({}));
  const double E = 1e5 + 2e5 * (1 - 0.025);  // of the lowest points, regular or not
  const double M = mpm::skeleton_modulus(settings.bodies[0]) * (1.3 * 0.4) / 0.7;
  EXPECT_NEAR(M, E, 0.01 * E);
  EXPECT_EQ(settings.bodies[0].varying.size(), 3u);
}

/// The laws of the points are those of their values, whatever order the points have.
TEST(VaryingSoil, laws_follow_the_points) {
  const auto settings = mpm_settings<2>(varying_scene({}));
  mpm::PointLaws<2> laws(settings.varying);
  mpm::MaterialPoints<2> points;
  mpm::lay_points<2>(settings.layouts[0], 1500, {}, points);
  mpm::lay_points<2>(settings.layouts[1], 1500, {.first_id = points.size()}, points);
  mpm::add_parameters<2>(settings.varying, points);
  const auto expect_own = [&] {
    laws.follow(points);
    ASSERT_EQ(laws.of_points().size(), points.x.size());
    for (std::int32_t p = 0; p < points.size(); ++p) {
      const auto& law = std::get<MohrCoulomb<2>>(*laws.of_points()[p]);
      const auto& values = points.parameters[p];  // cohesion, friction_angle, young_modulus
      EXPECT_EQ(law.parameters().cohesion, values[0]);
      EXPECT_NEAR(law.parameters().friction_angle, values[1] * M_PI / 180, 1e-15);
      EXPECT_NEAR(law.parameters().mu, values[2] / 2.6, 1e-9);
    }
  };
  expect_own();
  std::reverse(points.parameters.begin(), points.parameters.begin() + 20);
  expect_own();
  const std::vector<std::int32_t> some = {0, 7, 8, 30};
  mpm::remove_points<2>(some, points);
  expect_own();
  const auto weaker = laws.reduced(1.25);
  for (std::int32_t p = 0; p < points.size(); ++p) {
    EXPECT_DOUBLE_EQ(std::get<MohrCoulomb<2>>(*weaker.of_points()[p]).parameters().cohesion,
                     points.parameters[p][0] / 1.25);
  }
}

/// A strength that softens is refused where it falls too fast at any point.
TEST(VaryingSoil, snap_back_of_any_point_is_refused) {
  Json scene = collapse_scene({});
  Json& material = scene["bodies"][0]["material"];
  material["cohesion"] = by_depth({{0, 500}, {1, 5e4}}, 0.6);
  material["softening"] = {{"slip", 0.01}, {"residual_cohesion", 200}};
  expect_error<ConfigError>([&] { make_mpm(scene); },
                            {"/bodies/0/material/softening, material point", "slips"});
}

/// A cut in layers has the factor of safety of the same cut in bodies.
TEST(VaryingSoil, reduced_strength_of_layers) {
  if (size() > 1) return;
  const auto clay = [](double cohesion) {
    Json material = elastic_soil("tresca", 1e9, 0.3, 2000);
    material["cohesion"] = cohesion;
    return material;
  };
  const auto cut = [](const Json& bodies) {
    return Json{{"dimension", 2},
                {"analysis", "quasi_static"},
                {"basis", "linear"},
                {"grid", box({0, 0}, {12, 10}, {12, 10}, "quad4")},
                {"walls", {wall("bottom", "fixed"), wall("left", "slip"), wall("right", "slip")}},
                {"gravity", {0, -10}},
                {"bodies", bodies},
                {"phases",
                 {{{"strength_reduction",
                    {{"from", 0.5},
                     {"increment", 0.2},
                     {"tolerance", 0.02},
                     {"max_displacement", 0.04}}}}}}};
  };
  const auto bracket = [](const Json& scene) {
    const auto solver = make_mpm(scene);
    const auto result = [&] { return solver->summary().at("strength_reduction"); };
    for (int k = 0; k < 60 && (k == 0 || result().at("verdict") == "no_failure"); ++k) {
      const StepRequest request{k + 1, 0, static_cast<double>(k), 1};
      InterfaceValues sent;
      solver->solve_step(request, {}, sent);
      solver->accept_step(request, true);
    }
    return std::pair(result().at("equilibrium_with").get<double>(),
                     result().at("none_with").get<double>());
  };
  const Json base = box({0, 0}, {12, 4}, {12, 4}, "quad4");
  const Json bench = box({6, 4}, {12, 8}, {6, 4}, "quad4");
  const auto bodies =
      bracket(cut({body("base", base, 4, clay(4e4)), body("bench", bench, 4, clay(2e4))}));
  Json layered = clay(2e4);
  layered["layers"] = {{{"below", 4}, {"cohesion", 4e4}}};
  const auto layers =
      bracket(cut({body("base", base, 4, layered), body("bench", bench, 4, layered)}));
  EXPECT_EQ(bodies, layers);
  const auto strong =
      bracket(cut({body("base", base, 4, clay(4e4)), body("bench", bench, 4, clay(4e4))}));
  EXPECT_GT(strong.first, bodies.second);
}

}  // namespace
}  // namespace gabion::test::test_varying_soil
