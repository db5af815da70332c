// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>
#include <tuple>

#include "mpm_solver/points/flat.hpp"
#include "mpm_solver/points/point_totals.hpp"
#include "mpm_solver/walls/inelastic_projection.hpp"
#include "tests/support/expect_error.hpp"
#include "tests/unit/mpm/mpm_scene.hpp"
#include "tests/unit/mpm/soil_patch.hpp"

namespace gabion::test::test_inelastic_projection {
namespace {

/// Points in a box with a smooth floor and a rough wall on the left.
template <int dim>
struct Stopped {
  SoilPatch<dim> soil;
  mpm::WallConditions<dim> walls;
  mpm::InelasticProjection<dim> stop;

  Stopped(CellType type, mpm::Basis basis)
      : soil(type, 3, basis),
        walls(soil.grid, {{.group = "bottom", .fixed = false, .where = "", .motion = {}},
                          {.group = "left", .fixed = true, .where = "", .motion = {}}}) {
    soil.scatter(200);
    map();
  }
  void map() {
    soil.to_grid();
    walls.select(soil.nodes);
  }
  void find() { stop.find(soil.points, soil.weights, walls, 0.1, soil.nodes); }
};

/// Momentum of the points at the held nodes beyond that which they would have if they moved with
/// `v`.
template <int dim>
double through_walls(const Stopped<dim>& at, std::vector<Vector<dim>> v) {
  const auto& [soil, walls] = std::tie(at.soil, at.walls);
  walls.impose(flat(v), 1);
  std::vector<Vector<dim>> beyond(v.size(), Vector<dim>::Zero());
  for (const auto& group : soil.weights.groups) {
    std::int32_t active[mpm::max_group_nodes<dim>];
    soil.nodes.list_active(soil.weights.nodes_of(group), active);
    for (std::int32_t e = group.first; e < group.last; ++e) {
      const std::int32_t p = soil.weights.point[e];
      const double* N = soil.weights.N_of(e);
      const auto* local = soil.weights.local_of(e);
      Vector<dim> x = soil.points.v[p];
      for (int k = 0; k < soil.weights.num_nodes(e); ++k) x -= N[k] * v[active[local[k]]];
      for (int k = 0; k < soil.weights.num_nodes(e); ++k) {
        beyond[active[local[k]]] += N[k] * soil.points.m[p] / soil.nodes.m[active[local[k]]] * x;
      }
    }
  }
  double largest = 0;
  for (std::size_t c = 0; c < walls.constrained().size(); ++c) {
    const Vector<dim>& x = beyond[walls.constrained()[c]];
    largest = std::max(largest, (x - walls.projectors()[c] * x).norm());
  }
  return largest;
}

TEST(InelasticProjection, points_move_with_the_walls) {
  for_each_basis([]<int dim>(CellType type, mpm::Basis basis) {
    Stopped<dim> at(type, basis);
    const auto start = mpm::point_totals(comm(), at.soil.points);
    const double before = start.kinetic_energy;
    const auto v = at.soil.nodes.v;
    const double much = through_walls(at, v);
    EXPECT_GT(much, 0.1);
    at.find();
    at.stop.kick(at.soil.weights, at.soil.points);
    EXPECT_LT(through_walls(at, v), 0.25 * much);
    const auto end = mpm::point_totals(comm(), at.soil.points);
    EXPECT_NEAR(before - end.kinetic_energy, at.stop.totals().loss, 1e-12 * before);
    EXPECT_EQ(at.stop.totals().work, 0);
    const Vector<dim> change = end.momentum - start.momentum;
    EXPECT_LT((change - at.stop.totals().impulse).norm(), 1e-12 * before);
    const auto after = at.soil.nodes.v;
    at.map();
    auto mapped = at.soil.nodes.v;
    at.walls.impose(flat(mapped), 1);
    for (std::size_t i = 0; i < mapped.size(); ++i) {
      EXPECT_LT((after[i] - mapped[i]).norm(), 1e-12) << i;
    }
  });
}

/// Points that lag behind the nodes at a wall are not pushed.
TEST(InelasticProjection, a_wall_at_rest_gives_no_energy) {
  for_each_basis([]<int dim>(CellType type, mpm::Basis basis) {
    for (const double lag : {0.0, 0.2, 0.5}) {
      Stopped<dim> at(type, basis);
      auto& points = at.soil.points;
      for (std::int32_t p = 0; p < points.size(); ++p) {
        const bool is_near = points.x[p][dim - 1] < 1.0 / 3 || points.x[p][0] < 1.0 / 3;
        points.v[p] = (is_near ? lag : 1) * (points.v[p] - Vector<dim>::Ones());
      }
      at.map();
      const double before = mpm::point_totals(comm(), points).kinetic_energy;
      at.find();
      at.stop.kick(at.soil.weights, points);
      EXPECT_GE(at.stop.totals().loss, 0);
      EXPECT_LE(mpm::point_totals(comm(), points).kinetic_energy, before);
    }
  });
}

/// Soil that shears over a wall does not move through it, however often it is mapped.
TEST(InelasticProjection, shear_over_a_wall_goes_on) {
  for_each_cell_type([]<int dim>(CellType type) {
    SoilPatch<dim> soil(type);
    soil.fill(type == CellType::tri3 ? 3 : type == CellType::hex8 ? 8 : 4);
    for (std::int32_t p = 0; p < soil.points.size(); ++p) {
      soil.points.v[p].setZero();
      soil.points.v[p][0] = soil.points.x[p][dim - 1];
    }
    soil.to_grid();
    mpm::WallConditions<dim> walls(soil.grid,
                                   {{.group = "bottom", .fixed = true, .where = "", .motion = {}}});
    walls.select(soil.nodes);
    const double energy = mpm::point_totals(comm(), soil.points).kinetic_energy;
    mpm::InelasticProjection<dim> stop;
    stop.find(soil.points, soil.weights, walls, 0.1, soil.nodes);
    // Energy is lost in the first row of cells only; the nodes alone would lose 0.4 of it in each
    // step.
    EXPECT_LT(std::abs(stop.totals().loss), 0.01 * energy);
  });
}

/// A block that lands takes the same impulse and loses the same energy in any number of steps.
TEST(InelasticProjection, does_not_depend_on_the_step) {
  const auto fall = [](double dt, const Json& scheme) {
    Json sand = elastic_soil("mohr_coulomb", 1e5, 0.3, 1000);
    sand["friction_angle"] = 30;
    const auto solver = make_mpm(
        {{"dimension", 2},
         {"grid", box({0, 0}, {1, 2}, {4, 8}, "quad4")},
         {"walls", {wall("bottom", "slip"), wall("left", "slip"), wall("right", "slip")}},
         {"bodies", {body("block", box({0, 0.26}, {1, 1.26}, {8, 8}, "quad4"), 4, sand, {0, -1})}},
         {"time_integration", scheme}});
    run_steps(*solver, dt, static_cast<int>(std::lround(0.2 / dt)));
    return probe(*solver, "wall_loss");
  };
  for (const Json& scheme : {Json{{"scheme", "explicit"}}, trapezoid}) {
    const double small = fall(0.001, scheme), large = fall(0.005, scheme);
    EXPECT_GT(small, 10);
    EXPECT_NEAR(large, small, 0.2 * small) << scheme;
  }
}

}  // namespace
}  // namespace gabion::test::test_inelastic_projection
