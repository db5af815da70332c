// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>

#include "mpm_solver/walls/wall_stop.hpp"
#include "tests/support/expect_error.hpp"
#include "tests/unit/mpm/mpm_scene.hpp"
#include "tests/unit/mpm/soil_patch.hpp"

namespace gabion::test {
namespace {

template <int dim>
double kinetic_energy(const mpm::MaterialPoints<dim>& points) {
  double sum = 0;
  for (std::int32_t p = 0; p < points.size(); ++p) {
    sum += 0.5 * points.m[p] * points.v[p].squaredNorm();
  }
  return sum;
}
template <int dim>
Vector<dim> momentum(const mpm::MaterialPoints<dim>& points) {
  Vector<dim> sum = Vector<dim>::Zero();
  for (std::int32_t p = 0; p < points.size(); ++p) sum += points.m[p] * points.v[p];
  return sum;
}

/// Points in a box with a slip floor and a wall on the left that moves or holds.
template <int dim>
struct Stopped {
  SoilPatch<dim> soil;
  mpm::WallConditions<dim> walls;
  mpm::WallStop<dim> stop;

  Stopped(CellType type, mpm::Basis basis)
      : soil(type, 3, basis),
        walls(soil.grid.mesh, {{.group = "bottom", .fixed = false, .where = "", .motion = {}},
                               {.group = "left", .fixed = true, .where = "", .motion = {}}}) {
    soil.scatter(200);
    map();
  }
  void map() {
    soil.to_grid();
    walls.select(soil.nodes);
  }
  void find() { stop.find(soil.points, soil.weights, walls, 0.1, soil.nodes); }
  /// Largest velocity that walls would still stop.
  double left() const {
    double largest = 0;
    for (std::size_t c = 0; c < walls.constrained().size(); ++c) {
      const Vector<dim>& v = soil.nodes.v[walls.constrained()[c]];
      largest = std::max(largest, (v - walls.projectors()[c] * v).norm());
    }
    return largest;
  }
};

TEST(WallStop, points_have_the_velocity_of_the_walls) {
  for_each_basis([]<int dim>(CellType type, mpm::Basis basis) {
    Stopped<dim> at(type, basis);
    const double before = kinetic_energy(at.soil.points);
    const Vector<dim> p = momentum(at.soil.points);
    EXPECT_GT(at.left(), 0.1);
    at.find();
    EXPECT_LT(at.left(), 2e-3);
    const auto mapped = at.soil.nodes.v;
    at.stop.kick(at.soil.weights, at.soil.points);
    EXPECT_NEAR(before - kinetic_energy(at.soil.points), at.stop.totals().loss, 1e-12 * before);
    EXPECT_GT(at.stop.totals().loss, 0.02 * before);
    EXPECT_EQ(at.stop.totals().work, 0);
    const Vector<dim> change = momentum(at.soil.points) - p;
    EXPECT_LT((change - at.stop.totals().impulse).norm(), 1e-12 * before);
    at.map();
    for (std::size_t i = 0; i < mapped.size(); ++i) {
      EXPECT_LT((at.soil.nodes.v[i] - mapped[i]).norm(), 1e-12) << i;
    }
    // Nothing is left to stop.
    const double loss = at.stop.totals().loss;
    at.find();
    EXPECT_LT(at.stop.totals().loss, 1e-6 * loss);
  });
}

/// The change that takes the least kinetic energy: it stands on every one that the walls allow.
TEST(WallStop, takes_no_more_than_it_must) {
  Stopped<2> at(CellType::quad4, mpm::Basis::linear);
  const auto v = at.soil.points.v;
  at.find();
  at.stop.kick(at.soil.weights, at.soil.points);
  const auto after = at.soil.points.v;
  // Any other velocities, which the walls allow once they have stopped them.
  for (auto& x : at.soil.points.v) x = at.soil.random.template vector<2>();
  at.map();
  at.find();
  at.stop.kick(at.soil.weights, at.soil.points);
  double product = 0, size = 0;
  for (std::size_t k = 0; k < v.size(); ++k) {
    const double m = at.soil.points.m[k];
    product += m * (after[k] - v[k]).dot(at.soil.points.v[k]);
    size += m * (after[k] - v[k]).norm() * at.soil.points.v[k].norm();
  }
  EXPECT_LT(std::abs(product), 1e-3 * size);
}

/// A block that lands takes the same impulse and loses the same energy in any number of steps.
TEST(WallStop, does_not_depend_on_the_step) {
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
}  // namespace gabion::test
