// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "tests/unit/mpm/pushed_soil.hpp"

namespace gabion::test::test_slice {
namespace {

constexpr int cells = 4;

/// A block that falls on its corner of two walls and yields, of one cell of thickness in space.
template <int dim>
Json block(const std::string& basis, const Json& material) {
  const std::string type = dim == 2 ? "quad4" : "hex8";
  const double h = 1.0 / cells;
  const auto with_thickness = [](std::vector<double> place, double z) {
    if (dim == 3) place.push_back(z);
    return place;
  };
  std::vector<int> grid_count = {cells + 2, cells + 2}, count = {cells, cells};
  if (dim == 3) {
    grid_count.push_back(1);
    count.push_back(1);
  }
  Json soil = body("soil", box(with_thickness({0, 0}, 0), with_thickness({1, 1}, h), count, type),
                   dim == 2 ? 4 : 8, material, with_thickness({-0.3, -0.6}, 0));
  Json json = {{"dimension", dim},
               {"grid", box(with_thickness({0, 0}, 0), with_thickness({1 + 2 * h, 1 + 2 * h}, h),
                            grid_count, type)},
               {"basis", basis},
               {"locking", {{"method", "fbar"}}},
               {"gravity", with_thickness({0, -10}, 0)},
               {"walls", {wall("bottom", "slip"), wall("left", "fixed")}},
               {"bodies", {soil}},
               {"newton", exact_newton}};
  if (dim == 3) {
    // front and back are the sides along y, which is up in the plane
    json["walls"] = {wall("front", "slip"), wall("left", "fixed"), wall("bottom", "slip"),
                     wall("top", "slip")};
  }
  return json;
}

/// The points of a slice of one cell between slip walls are those of the plane, twice.
void check_slice(const std::string& basis, const Json& material, bool is_explicit,
                 double tolerance = 1e-9) {
  Json plane = block<2>(basis, material), slice = block<3>(basis, material);
  for (Json* json : {&plane, &slice}) {
    if (is_explicit) {
      (*json)["time_integration"] = {{"scheme", "explicit"}};
      json->erase("newton");
    }
  }
  const auto in_plane = mpm_solver<2>(plane);
  const auto in_space = mpm_solver<3>(slice);
  run_steps(*in_plane, 5e-3, 6);
  run_steps(*in_space, 5e-3, 6);
  const auto& flat = in_plane->points();
  const auto& thick = in_space->points();
  ASSERT_EQ(thick.size(), 2 * flat.size());
  double largest = 0, yielding = 0;
  for (std::int32_t q = 0; q < thick.size(); ++q) {
    std::int32_t p = 0;  // the point of the plane that began at the same place
    const auto start = [](const auto& points, std::int32_t k) {
      return Vector<2>((points.x[k] - points.u[k]).template head<2>());
    };
    while (p < flat.size() && (start(thick, q) - start(flat, p)).norm() > 1e-9) ++p;
    ASSERT_LT(p, flat.size());
    EXPECT_LT((thick.u[q].head<2>() - flat.u[p]).norm(), 0.1 * tolerance);
    EXPECT_LT(std::abs(thick.u[q][2]), 0.1 * tolerance);
    EXPECT_NEAR(thick.J[q], flat.J[p], tolerance);
    EXPECT_LT((thick.tau[q].head<4>() - flat.tau[p]).norm(), 10 * tolerance * 1e5);
    largest = std::max(largest, flat.u[p].norm());
    yielding += flat.history[p].plastic_strain > 0;
  }
  EXPECT_GT(largest, 5e-3);
  EXPECT_NEAR(probe(*in_space, "elastic_energy") * cells, probe(*in_plane, "elastic_energy"),
              tolerance * probe(*in_plane, "elastic_energy"));
  if (material.contains("friction_angle") || material.contains("cohesion")) {
    EXPECT_GT(yielding, 0.1 * flat.size());
  }
}

std::vector<Json> soils() {
  Json sand = elastic_soil("mohr_coulomb", 1e5, 0.3, 1000);
  sand["friction_angle"] = 30;
  sand["dilation_angle"] = 10;
  Json cone = sand;
  cone["law"] = "drucker_prager";
  Json clay = elastic_soil("tresca", 1e5, 0.4, 1000);
  clay["cohesion"] = 500;
  Json cracking = clay;
  cracking["tension_cutoff"] = 100;
  return {elastic_soil("linear_elastic", 1e5, 0.47, 1000),
          elastic_soil("neo_hookean", 1e5, 0.47, 1000),
          elastic_soil("hencky_elastic", 1e5, 0.47, 1000),
          sand,
          cone,
          clay,
          cracking};
}

TEST(Slice, of_one_cell_is_the_plane) {
  for (const Json& material : soils()) {
    check_slice("linear", material, false);
    check_slice("linear", material, true);
    if (::testing::Test::HasFailure()) FAIL() << material;
  }
}

TEST(Slice, of_one_cell_is_the_plane_on_smooth_functions) {
  for (const bool is_explicit : {false, true}) {
    check_slice("bspline", soils()[3], is_explicit);
    // (S14) lets domains of gimp keep their volume along all axes of space: of second order in
    // shear
    check_slice("gimp", soils()[3], is_explicit, 1e-6);
  }
}

}  // namespace
}  // namespace gabion::test::test_slice
