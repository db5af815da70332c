// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "common/hdf5/hdf5_reader.hpp"
#include "mpm_solver/report/contact_output.hpp"
#include "tests/unit/mpm/mpm_scene.hpp"

namespace gabion::test::test_contact_output {
namespace {

/// A block of 1 m on a rigid floor that goes by a given displacement upwards and to the side in
/// each step of 0.01 s.
template <int dim>
Json lifted_block(const std::string& method, double up = 0.01, double aside = 0) {
  const bool flat = dim == 2;
  Json block =
      flat ? box({0, 0}, {1, 1}, {2, 2}, "quad4") : box({0, 0, 0}, {1, 1, 1}, {2, 2, 2}, "hex8");
  Json soil = body("block", block, flat ? 4 : 8, elastic_soil("linear_elastic", 1e6, 0, 1000));
  soil["point_placement"] = "regular";
  Json motion = {{"velocity", {100 * aside, 100 * up}}};
  Json surface = {{"polyline", {{1.2, 0}, {-0.2, 0}}}, {"spacing", 0.17}};
  if (!flat) {
    motion = {{"velocity", {100 * aside, 0, 100 * up}}};
    surface = {{"mesh", box({0, 0, -1}, {1, 1, 0}, {2, 2, 1}, "hex8")}, {"groups", {"top"}}};
  }
  return {{"dimension", dim},
          {"grid", flat ? box({-0.5, -0.5}, {1.5, 1.5}, {4, 4}, "quad4")
                        : box({-0.5, -0.5, -0.5}, {1.5, 1.5, 1.5}, {4, 4, 4}, "hex8")},
          {"basis", "linear"},
          {"bodies", {soil}},
          {"newton", exact_newton},
          {"rigid_walls",
           {{{"name", "floor"},
             {"method", method},
             {"friction", 0.3},
             {"surface", surface},
             {"motion", motion}}}}};
}

/// Length of a facet of the plane, and that which is below the block.
struct Covered {
  double length, under_block;
};

Covered covered(const mpm::ContactFields<2>& fields, std::size_t f) {
  const double left = fields.vertices[f + 1][0], right = fields.vertices[f][0];
  return {right - left, std::max(0.0, std::min(right, 1.0) - std::max(left, 0.0))};
}

/// Evenly laid points give an even pressure, although facets end anywhere below them.
TEST(ContactOutput, pressure_below_a_block_is_force_over_area) {
  const auto solver = mpm_solver<2>(lifted_block<2>("facets"));
  run_steps(*solver, 0.01, 1);
  const auto fields = solver->surfaces().fields(0, solver->points(), 0.5);
  const auto frame = mpm::contact_frame<2>(solver->surfaces().settings(0).surface, fields);
  const double force = -probe(*solver, "floor.fy");
  EXPECT_GT(force, 100);
  double sum = 0;
  for (std::size_t f = 0; f < frame.pressure.size(); ++f) {
    const Covered on = covered(fields, f);
    sum += on.length * frame.pressure[f];
    if (std::abs(on.under_block - on.length) < 1e-9) {
      EXPECT_NEAR(frame.pressure[f], force, 1e-9 * force);
      EXPECT_NEAR(frame.shear[2 * f], 0, 1e-9 * force);
    }
    EXPECT_EQ(frame.status[f] > 0, on.under_block > 0);
    EXPECT_EQ(frame.pressure[f] > 0, on.under_block > 0);
  }
  EXPECT_NEAR(sum, force, 1e-9 * force);
}

TEST(ContactOutput, boundary_points_keep_their_force_on_their_facet) {
  Json json = lifted_block<2>("boundary_points");
  json["rigid_walls"][0]["surface"] = {{"polyline", {{1, 0}, {0, 0}}}, {"spacing", 0.17}};
  const auto solver = mpm_solver<2>(json);
  run_steps(*solver, 0.01, 1);
  const auto fields = solver->surfaces().fields(0, solver->points(), 0.5);
  const auto frame = mpm::contact_frame<2>(solver->surfaces().settings(0).surface, fields);
  const double force = -probe(*solver, "floor.fy");
  EXPECT_GT(force, 100);
  double sum = 0;
  for (std::size_t f = 0; f < frame.pressure.size(); ++f) {
    sum += frame.pressure[f] * covered(fields, f).length;
    EXPECT_LT(frame.gap[f], 0);
    EXPECT_EQ(frame.status[f], frame.status[0]);
  }
  EXPECT_NEAR(sum, force, 1e-12 * force);
}

TEST(ContactOutput, pressure_in_space) {
  for (const char* method : {"facets", "boundary_points"}) {
    const auto solver = mpm_solver<3>(lifted_block<3>(method));
    run_steps(*solver, 0.01, 1);
    const auto fields = solver->surfaces().fields(0, solver->points(), 0.5);
    const auto frame = mpm::contact_frame<3>(solver->surfaces().settings(0).surface, fields);
    const double force = -probe(*solver, "floor.fz");
    EXPECT_GT(force, 100);
    ASSERT_EQ(frame.pressure.size(), 4U);
    for (const double p : frame.pressure) EXPECT_NEAR(p, force, 1e-9 * force) << method;
    for (const double t : frame.shear) EXPECT_NEAR(t, 0, 1e-9 * force) << method;
  }
}

/// The forces of the facets add up to the resultant, along the surface too.
TEST(ContactOutput, shear_of_a_floor_that_goes_aside) {
  for (const char* method : {"facets", "boundary_points"}) {
    const auto solver = mpm_solver<3>(lifted_block<3>(method, 0.01, 0.002));
    run_steps(*solver, 0.01, 1);
    const auto fields = solver->surfaces().fields(0, solver->points(), 0.5);
    const auto frame = mpm::contact_frame<3>(solver->surfaces().settings(0).surface, fields);
    Vector<3> sum = Vector<3>::Zero();
    for (int f = 0; f < 4; ++f) {
      sum += 0.25 * Vector<3>(frame.shear[3 * f], frame.shear[3 * f + 1], -frame.pressure[f]);
      EXPECT_EQ(frame.shear[3 * f + 2], 0);
    }
    const double force = -probe(*solver, "floor.fz");
    EXPECT_NEAR(sum[0], probe(*solver, "floor.fx"), 1e-9 * force) << method;
    EXPECT_NEAR(sum[2], -force, 1e-9 * force) << method;
    EXPECT_LT(sum[0], -0.01 * force) << method;
  }
}

/// A block in contact with a floor overlaps nothing where the floor falls away beside it.
TEST(ContactOutput, no_overlap_beyond_a_crest) {
  Json json = lifted_block<2>("facets");
  json["rigid_walls"][0]["surface"] = {{"polyline", {{1.4, -0.15}, {1, 0}, {-0.2, 0}}},
                                       {"spacing", 0.15}};
  const auto solver = mpm_solver<2>(json);
  const auto fields = solver->surfaces().fields(0, solver->points(), 0.2);
  double least = 1;
  int beyond = 0;
  for (std::size_t f = 0; f < fields.gap.size(); ++f) {
    least = std::min(least, fields.gap[f]);
    beyond += fields.vertices[f][0] > 1 && std::isfinite(fields.gap[f]);
  }
  EXPECT_NEAR(least, 0, 1e-12);
  EXPECT_GT(beyond, 0);
}

/// Open: the gap is the distance; and nothing is known where no point is near.
TEST(ContactOutput, gap_before_anything_moves) {
  Json json = lifted_block<2>("facets");
  json["rigid_walls"][0]["surface"] = {{"polyline", {{1.4, -0.125}, {-0.4, -0.125}}},
                                       {"spacing", 0.15}};
  const auto solver = mpm_solver<2>(json);
  const auto fields = solver->surfaces().fields(0, solver->points(), 0.2);
  const auto frame = mpm::contact_frame<2>(solver->surfaces().settings(0).surface, fields);
  for (std::size_t f = 0; f < frame.gap.size(); ++f) {
    const Covered on = covered(fields, f);
    if (on.under_block > 1e-9) {
      EXPECT_NEAR(frame.gap[f], 0.125, 1e-12);
    }
    EXPECT_EQ(frame.status[f], 0);
    EXPECT_EQ(frame.pressure[f], 0);
  }
  EXPECT_TRUE(std::isnan(frame.gap.front()));
  EXPECT_TRUE(std::isnan(frame.gap.back()));
}

/// Points far from each other share a look at the surface as neighbours do: each gap is the
/// smallest of those that the points have one by one, in whatever order they stand.
template <int dim>
void expect_gaps_of_single_points(double reach) {
  const auto solver = mpm_solver<dim>(lifted_block<dim>("facets"));
  const mpm::ContactSurface<dim>& surface = solver->surfaces().settings(0).surface;
  const auto start = solver->surfaces().fields(0, solver->points(), reach);
  const mpm::ContactFields<dim> none(start.vertices, start.gap.size());
  const auto sphere_of = [](std::int32_t) {
    return mpm::ContactSphere<dim>{0.02 * Matrix<dim>::Identity(), Vector<dim>::Zero()};
  };
  mpm::MaterialPoints<dim> all;
  mpm::ContactFields<dim> expected = none, found = none;
  for (int k = 0; k < 100; ++k) {
    Vector<dim> x;
    for (int d = 0; d < dim; ++d) x[d] = std::fmod((k + 1) * (0.618034 + 0.1357 * d), 1.0);
    mpm::MaterialPoints<dim> one;
    for (auto* points : {&all, &one}) {
      points->x.push_back(x);
      points->V0.push_back(1e-3);
      points->J.push_back(1);
    }
    mpm::ContactFields<dim> fields = none;
    mpm::add_gaps<dim>(surface, one, sphere_of, reach, fields);
    for (std::size_t f = 0; f < fields.gap.size(); ++f) {
      expected.gap[f] = std::min(expected.gap[f], fields.gap[f]);
    }
  }
  mpm::add_gaps<dim>(surface, all, sphere_of, reach, found);
  EXPECT_EQ(found.gap, expected.gap);
  EXPECT_TRUE(std::any_of(found.gap.begin(), found.gap.end(), [](double g) { return g < 1; }));
}

TEST(ContactOutput, gaps_of_scattered_points) {
  for (const double reach : {0.01, 0.05, 0.3}) {
    expect_gaps_of_single_points<2>(reach);
    expect_gaps_of_single_points<3>(reach);
  }
}

/// Soil that moves along the floor faster than friction holds it: slides, at its velocity.
TEST(ContactOutput, sliding_soil) {
  for (const char* method : {"facets", "boundary_points"}) {
    Json json = lifted_block<2>(method, 1e-3);
    json["bodies"][0]["velocity"] = {2, 0};
    json["rigid_walls"][0]["friction"] = 0.01;
    json["rigid_walls"][0]["surface"]["polyline"] = {{1, 0}, {0, 0}};
    const auto solver = mpm_solver<2>(json);
    run_steps(*solver, 0.01, 1);
    const auto fields = solver->surfaces().fields(0, solver->points(), 0.5);
    const auto frame = mpm::contact_frame<2>(solver->surfaces().settings(0).surface, fields);
    for (std::size_t f = 0; f < frame.status.size(); ++f) {
      EXPECT_EQ(frame.status[f], 2) << method;
      EXPECT_NEAR(frame.slip[2 * f], 2, 0.02) << method;
      EXPECT_NEAR(frame.shear[2 * f], 0.01 * frame.pressure[f], 1e-9 * frame.pressure[f]);
    }
  }
}

/// A saved state gives the same fields again.
TEST(ContactOutput, restart_keeps_the_fields) {
  for (const char* method : {"facets", "boundary_points"}) {
    const Json json = lifted_block<2>(method);
    const auto first = mpm_solver<2>(json), again = mpm_solver<2>(json);
    run_steps(*first, 0.01, 2);
    again->load_state(first->save_state());
    const auto a = first->surfaces().fields(0, first->points(), 0.5);
    const auto b = again->surfaces().fields(0, again->points(), 0.5);
    EXPECT_EQ(a.vertices, b.vertices);
    EXPECT_EQ(a.force, b.force);
    EXPECT_EQ(a.slip, b.slip);
    EXPECT_EQ(a.gap, b.gap);
    EXPECT_EQ(a.status, b.status);
    EXPECT_GT(a.area[1], 0);
  }
}

TEST(ContactOutput, a_series_for_each_surface) {
  const auto folder = std::filesystem::temp_directory_path() / "gabion_contact_output";
  std::filesystem::remove_all(folder);
  mpm::MpmSolver<2> solver(comm(), mpm_settings<2>(lifted_block<2>("facets")), folder.string());
  solver.write_output(0);
  run_steps(solver, 0.01, 1);
  solver.write_output(0.01);
  EXPECT_TRUE(std::filesystem::exists(folder / "contact_floor.xdmf"));
  const Hdf5Reader file((folder / "contact_floor_000001.h5").string());
  const auto x = file.reals("coordinates");
  EXPECT_NEAR(x[0], 1.2, 1e-12);
  EXPECT_NEAR(x[1], 0.01, 1e-12);
  EXPECT_EQ(file.integers("connectivity").size(), 2 * (x.size() / 3 - 1));
  EXPECT_EQ(file.names("cell"),
            (std::vector<std::string>{"gap", "pressure", "shear", "slip", "status"}));
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace gabion::test::test_contact_output
