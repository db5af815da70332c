// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <limits>
#include <optional>

#include "mpm_solver/step/seepage_balance.hpp"
#include "tests/support/check_tangent.hpp"
#include "tests/unit/mpm/soil_patch.hpp"

namespace gabion::test::test_seepage_forces {
namespace {

constexpr int seepage_cells = 2;

/// Soil with water that drains, under random pressures, and one balance of it.
template <int dim>
struct WetBalance {
  static constexpr int block = dim + 1;
  SoilPatch<dim> soil;
  mpm::Contacts<dim> contacts;
  mpm::TrialPoints<dim> trial;
  NewmarkBossak scheme = NewmarkBossak::bossak(-0.1);
  std::optional<mpm::WallConditions<dim>> walls;
  std::optional<mpm::SeepageForces<dim>> water;
  std::optional<mpm::Equilibrium<dim>> equilibrium;
  std::optional<mpm::SeepageBalance<dim>> balance;
  BlockMatrix<dim> K_uu;
  BlockMatrix<block> K;
  mpm::DrainedNodes drained;

  WetBalance(mpm::Basis basis, bool averages, bool with_inertia, bool kozeny_carman = false,
             const mpm::PoolLevels& pools = {},
             double suction_limit = std::numeric_limits<double>::infinity())
      : soil(dim == 2 ? CellType::quad4 : CellType::hex8, seepage_cells, basis) {
    soil.grid.splits_border = averages && basis == mpm::Basis::bspline;
    soil.fill(1 << dim, 1.5);
    mpm::PoreWater pores;
    pores.porosity = 0.4;
    pores.bulk_modulus = 5e4;
    pores.density = 1;
    pores.cavitation = suction_limit;
    pores.permeability = 0.02;
    pores.kozeny_carman = kozeny_carman;
    soil.bodies = {{"soil", {"", 1.5, NeoHookean<dim>{4e3, 3e3}}, pores}};
    for (std::int32_t p = 0; p < soil.points.size(); ++p) {
      soil.points.x[p] += 0.1 / seepage_cells * soil.random.template vector<dim>();
      soil.points.J[p] = 1 + 0.03 * soil.random();
      soil.points.water.push_back(pores.content_at(2e3 * soil.random(), soil.points.J[p]));
    }
    soil.to_grid();
    walls.emplace(soil.grid, std::vector<mpm::WallSettings>{});
    walls->select(soil.nodes);
    const Vector<dim> gravity = Vector<dim>::Constant(-3.0);
    const double dt = 0.1, h = 1.0 / seepage_cells;
    water.emplace(
        mpm::StressParts<dim>{.bodies = soil.bodies,
                              .points = soil.points,
                              .weights = soil.weights,
                              .nodes = soil.nodes,
                              .trial = trial},
        mpm::SeepageStepData<dim>{.gravity = gravity,
                                  .dt = dt,
                                  .cell_size = h,
                                  .inertia_slope = with_inertia ? scheme.inertia_slope(dt) : 0,
                                  .averages = averages,
                                  .pools = pools});
    equilibrium.emplace(typename mpm::Equilibrium<dim>::Parts{.comm = comm(),
                                                              .grid = soil.grid,
                                                              .bodies = soil.bodies,
                                                              .points = soil.points,
                                                              .weights = soil.weights,
                                                              .nodes = soil.nodes,
                                                              .walls = *walls,
                                                              .contacts = contacts,
                                                              .trial = trial,
                                                              .scheme = scheme,
                                                              .gravity = gravity,
                                                              .gravity_start = gravity,
                                                              .cell_size = h,
                                                              .same_strain = 0,
                                                              .dt = dt,
                                                              .with_inertia = with_inertia,
                                                              .f_pore = water->forces(),
                                                              .average_volumes = averages});
    std::vector<std::int32_t> offsets, nodes;
    equilibrium->pattern(offsets, nodes);
    K_uu.set_pattern(soil.nodes.size(), offsets, nodes);
    K.set_pattern(soil.nodes.size(), offsets, nodes);
    balance.emplace(*equilibrium, *water, K_uu, drained);
  }
  /// Open the surface at some points, whatever is around them.
  void open() {
    std::vector<mpm::OuterPoint<dim>> surface;
    for (std::int32_t p = 0; p < soil.points.size(); p += 3) {
      surface.push_back({.point = p,
                         .n = soil.random.template vector<dim>().normalized(),
                         .R = 0.1,
                         .area = 0.3});
    }
    water->open(soil.grid, surface);
  }
  Eigen::VectorXd residual(const Eigen::VectorXd& x, BlockMatrix<block>* matrix = nullptr) {
    const auto n = static_cast<std::size_t>(x.size());
    Eigen::VectorXd r(x.size());
    const Evaluation result = balance->evaluate({x.data(), n}, {r.data(), n}, matrix);
    EXPECT_TRUE(result.admissible) << result.reason;
    return r;
  }
  Eigen::VectorXd random_unknowns(double size) {
    const auto values =
        soil.random.values(static_cast<std::size_t>(soil.nodes.size()) * block, size);
    return Eigen::Map<const Eigen::VectorXd>(values.data(),
                                             static_cast<Eigen::Index>(values.size()));
  }
  double error(const Eigen::VectorXd& x, double step) {
    residual(x, &K);
    const Eigen::Index n = x.size();
    Eigen::MatrixXd tangent(n, n);
    for (Eigen::Index k = 0; k < n; ++k) {
      const Eigen::VectorXd unit = Eigen::VectorXd::Unit(n, k);
      Eigen::VectorXd column(n);
      K.multiply({unit.data(), static_cast<std::size_t>(n)},
                 {column.data(), static_cast<std::size_t>(n)});
      tangent.col(k) = column;
    }
    return tangent_error([&](const Eigen::VectorXd& at) { return Eigen::VectorXd(-residual(at)); },
                         x, tangent, step);
  }
};

template <class Act>
void for_each_form(const Act& act) {
  for (const mpm::Basis basis : {mpm::Basis::gimp, mpm::Basis::bspline}) {
    for (const bool averages : {false, true}) {
      for (const bool inertia : {false, true}) {
        SCOPED_TRACE(std::string(basis_name(basis)) + (averages ? " fbar" : " none") +
                     (inertia ? " dynamic" : " quasi-static"));
        act(basis, averages, inertia);
      }
    }
  }
}

TEST(SeepageTangent, agrees_with_differences) {
  for_each_form([](mpm::Basis basis, bool averages, bool inertia) {
    WetBalance<2> plane(basis, averages, inertia);
    EXPECT_LT(plane.error(plane.random_unknowns(0.02), 1e-4), 1e-7);
  });
}

TEST(SeepageTangent, agrees_with_differences_where_water_leaves_and_the_permeability_changes) {
  for_each_form([](mpm::Basis basis, bool averages, bool inertia) {
    WetBalance<2> plane(basis, averages, inertia, true);
    plane.open();
    EXPECT_LT(plane.error(plane.random_unknowns(0.02), 1e-4), 1e-7);
    EXPECT_GT(plane.water->outflow(), 0);
  });
}

/// Half of the points are under suction, up to twice the one that grains feel at most.
TEST(SeepageTangent, agrees_with_differences_where_air_enters) {
  for_each_form([](mpm::Basis basis, bool averages, bool inertia) {
    WetBalance<2> plane(basis, averages, inertia, true, {}, 1e3);
    plane.open();
    EXPECT_LT(plane.error(plane.random_unknowns(0.02), 1e-4), 1e-7);
  });
  WetBalance<3> space(mpm::Basis::gimp, true, false, false, {}, 1e3);
  EXPECT_LT(space.error(space.random_unknowns(0.01), 1e-4), 1e-7);
}

/// Two pools whose levels cut the soil, and of which the water is heavy.
mpm::PoolLevels two_pools() {
  std::vector<mpm::Pool> pools(2);
  pools[0].to = 0.3;
  pools[0].level = TimeFunction::constant(0.9);
  pools[1].from = 0.8;
  pools[1].level = TimeFunction::constant(0.4);
  return {pools, 0, 4e3};
}

TEST(SeepageTangent, agrees_with_differences_under_pools) {
  for_each_form([](mpm::Basis basis, bool averages, bool inertia) {
    WetBalance<2> plane(basis, averages, inertia, true, two_pools());
    plane.open();
    EXPECT_LT(plane.error(plane.random_unknowns(0.02), 1e-4), 1e-7);
    EXPECT_NE(plane.water->inflow_work(), 0);
  });
  WetBalance<3> space(mpm::Basis::gimp, true, false, true, two_pools());
  EXPECT_LT(space.error(space.random_unknowns(0.01), 1e-4), 1e-7);
}

/// The force of a pool on soil that does not move is its buoyancy, whatever the cells.
TEST(SeepageForces, force_of_a_pool_is_the_weight_of_its_water) {
  std::vector<mpm::Pool> pools(1);
  pools[0].level = TimeFunction::constant(5);
  for (const bool averages : {false, true}) {
    WetBalance<2> plane(mpm::Basis::gimp, averages, false, false, {pools, 0, 4e3});
    plane.residual(Eigen::VectorXd::Zero(plane.soil.nodes.size() * 3));
    double volume = 0;
    const auto& points = plane.soil.points;
    for (std::int32_t p = 0; p < points.size(); ++p) volume += points.V0[p] * points.J[p];
    const Vector<2> force = plane.water->pool_force();
    EXPECT_NEAR(force[1], 4e3 * volume, 1e-9 * 4e3 * volume);
    EXPECT_NEAR(force[0], 0, 1e-9 * 4e3 * volume);
  }
}

TEST(SeepageTangent, agrees_with_differences_in_space) {
  for (const bool averages : {false, true}) {
    WetBalance<3> space(mpm::Basis::gimp, averages, false, averages);
    if (averages) space.open();
    EXPECT_LT(space.error(space.random_unknowns(0.01), 1e-4), 1e-7) << averages;
  }
}

/// Water that one place loses another gets: the rows of all nodes add up to the change of the water
/// in the points and that which left, whatever the seepage and the stabilisation.
void rows_add_up(double suction_limit) {
  for_each_form([suction_limit](mpm::Basis basis, bool averages, bool inertia) {
    WetBalance<2> plane(basis, averages, inertia, false, {}, suction_limit);
    plane.open();
    plane.residual(plane.random_unknowns(0.02));
    EXPECT_GT(plane.water->outflow(), 0);
    double sum = -plane.water->outflow();
    for (const double volume : plane.water->volumes()) sum += volume;
    mpm::MaterialPoints<2> after = plane.soil.points;
    plane.water->store(after);
    double change = 0, size = 0, mass = 0;
    for (std::int32_t p = 0; p < after.size(); ++p) {
      const double of_point = after.V0[p] * (after.water[p] - plane.soil.points.water[p]);
      change += of_point;
      size += std::abs(of_point);
      mass += after.m[p] - plane.soil.points.m[p];
    }
    EXPECT_GT(std::abs(change), 1e-3 * size);
    EXPECT_NEAR(sum, change, 1e-12 * size);
    EXPECT_NEAR(mass, change, 1e-12 * size);
  });
}

TEST(SeepageForces, the_rows_add_up_to_the_change_of_the_content) {
  rows_add_up(std::numeric_limits<double>::infinity());
}

TEST(SeepageForces, so_they_do_where_air_enters) {
  rows_add_up(1e3);
}

/// Water at rest has the same unknown at all nodes, and does not flow.
TEST(SeepageForces, water_at_rest_has_no_flux) {
  for (const bool averages : {false, true}) {
    WetBalance<2> plane(mpm::Basis::gimp, averages, false);
    mpm::MaterialPoints<2> points = plane.soil.points;
    for (std::int32_t p = 0; p < points.size(); ++p) {
      const double pressure = plane.water->at_rest(0, points.x[p]) + 10;
      points.water[p] = plane.soil.bodies[0].water->content_at(pressure, points.J[p]);
    }
    mpm::SeepageForces<2> water(
        {.bodies = plane.soil.bodies,
         .points = points,
         .weights = plane.soil.weights,
         .nodes = plane.soil.nodes,
         .trial = plane.trial},
        {.gravity = Vector<2>::Constant(-3.0), .dt = 0.1, .cell_size = 0.5, .averages = averages});
    const std::vector<double> du(plane.soil.num_dofs(), 0.0);
    const std::vector<double> q = water.start_heads();
    for (const double head : q) EXPECT_NEAR(head, 10, 1e-9);
    mpm::RefusedPoint worst;
    ASSERT_TRUE(water.evaluate({.du = du, .q = q}, nullptr, worst));
    for (const double volume : water.volumes()) EXPECT_NEAR(volume, 0, 1e-13);
  }
}

}  // namespace
}  // namespace gabion::test::test_seepage_forces
