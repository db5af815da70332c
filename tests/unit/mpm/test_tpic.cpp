// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "tests/unit/mpm/soil_patch.hpp"

namespace gabion::test::test_tpic {
namespace {

constexpr double round_off = 1e-13;

template <int dim>
Matrix<dim> random_matrix(Random& random) {
  Matrix<dim> result;
  for (int d = 0; d < dim; ++d) result.col(d) = random.vector<dim>();
  return result;
}

/// Points at random places, one of them on a node, that carry random gradients.
template <int dim>
void scatter_with_gradients(SoilPatch<dim>& soil) {
  soil.scatter(60);
  soil.add(Vector<dim>::Constant(1.0 / 3));  // the other nodes of its cell get no weight
  add_gradients(soil.points);
  for (auto& grad : soil.points.grad_v) grad = random_matrix<dim>(soil.random);
  for (auto& grad : soil.points.grad_a) grad = random_matrix<dim>(soil.random);
}

/// Rotation by an infinitesimal or finite angle; in 3D about an oblique axis.
template <int dim>
Matrix<dim> rotation(double angle) {
  if constexpr (dim == 2) {
    return Eigen::Rotation2Dd(angle).toRotationMatrix();
  } else {
    return Eigen::AngleAxisd(angle, Vector<3>(1, 2, -2) / 3).toRotationMatrix();
  }
}

template <int dim>
Matrix<dim> spin() {
  constexpr double h = 1e-6;
  return (rotation<dim>(h) - rotation<dim>(-h)) / (2 * h);
}

TEST(Tpic, linear_momentum_and_its_moment_reach_the_grid) {
  for_each_cell_type([]<int dim>(CellType type) {
    SoilPatch<dim> soil(type);
    scatter_with_gradients(soil);
    soil.to_grid();
    ForceAndMoment<dim> points, nodes, points_a, nodes_a;
    for (const auto& group : soil.weights.groups) {
      const auto cell = soil.weights.nodes_of(group);
      for (std::int32_t e = group.first; e < group.last; ++e) {
        const std::int32_t p = soil.weights.point[e];
        const double m = soil.points.m[p];
        points.add(soil.points.x[p], m * soil.points.v[p]);
        points_a.add(soil.points.x[p], m * soil.points.a[p]);
        for (int i = 0; i < soil.weights.num_nodes(e); ++i) {
          const double share = m * soil.weights.N_of(e)[i];
          const Vector<dim> arm =
              soil.mesh.nodes[cell[soil.weights.local_of(e)[i]]] - soil.points.x[p];
          points.moment += cross<dim>(arm, share * (soil.points.grad_v[p] * arm));
          points_a.moment += cross<dim>(arm, share * (soil.points.grad_a[p] * arm));
        }
      }
    }
    for (std::int32_t i = 0; i < soil.nodes.size(); ++i) {
      nodes.add(soil.node(i), soil.nodes.m[i] * soil.nodes.v[i]);
      nodes_a.add(soil.node(i), soil.nodes.m[i] * soil.nodes.a[i]);
    }
    EXPECT_LT((points.force - nodes.force).norm(), round_off * points.size);
    EXPECT_LT((points.moment - nodes.moment).norm(), round_off * points.size);
    EXPECT_LT((points_a.force - nodes_a.force).norm(), round_off * points.size);
    EXPECT_LT((points_a.moment - nodes_a.moment).norm(), round_off * points.size);
  });
}

/// A linear velocity field stays what it is, at nodes without weight too.
TEST(Tpic, linear_fields_survive_the_way_to_the_grid_and_back) {
  for_each_cell_type([]<int dim>(CellType type) {
    SoilPatch<dim> soil(type);
    scatter_with_gradients(soil);
    const Matrix<dim> L = random_matrix<dim>(soil.random), G = random_matrix<dim>(soil.random);
    for (std::int32_t p = 0; p < soil.points.size(); ++p) {
      soil.points.v[p] = L * soil.points.x[p];
      soil.points.a[p] = G * soil.points.x[p];
      soil.points.grad_v[p] = L;
      soil.points.grad_a[p] = G;
    }
    soil.to_grid();
    mpm::NodalMotion<dim> motion;
    motion.du.assign(soil.nodes.m.size(), Vector<dim>::Zero());
    motion.v_new = soil.nodes.v;
    motion.a_new = soil.nodes.a;
    for (std::int32_t i = 0; i < soil.nodes.size(); ++i) {
      EXPECT_LT((soil.nodes.v[i] - L * soil.node(i)).norm(), 1e-12) << name(type);
      EXPECT_LT((soil.nodes.a[i] - G * soil.node(i)).norm(), 1e-12) << name(type);
    }
    grid_to_points(soil.nodes, motion, soil.weights, 1, soil.points);
    for (std::int32_t p = 0; p < soil.points.size(); ++p) {
      EXPECT_LT((soil.points.v[p] - L * soil.points.x[p]).norm(), 1e-12);
      EXPECT_LT((soil.points.a[p] - G * soil.points.x[p]).norm(), 1e-12);
      EXPECT_LT((soil.points.grad_v[p] - L).norm(), 1e-11);
      EXPECT_LT((soil.points.grad_a[p] - G).norm(), 1e-11);
    }
  });
}

/// In one large step of a rigid rotation the points get the spin as gradient at their new places.
TEST(Tpic, gradients_are_those_of_the_new_positions) {
  for_each_cell_type([]<int dim>(CellType type) {
    SoilPatch<dim> soil(type);
    scatter_with_gradients(soil);
    soil.to_grid();
    const Matrix<dim> R = rotation<dim>(0.7), W = spin<dim>();
    mpm::NodalMotion<dim> motion;
    for (std::int32_t i = 0; i < soil.nodes.size(); ++i) {
      const Vector<dim> x = R * soil.node(i);
      motion.du.push_back(x - soil.node(i));
      motion.v_new.push_back(W * x);
      motion.a_new.push_back(W * (W * x));
    }
    grid_to_points(soil.nodes, motion, soil.weights, 1, soil.points);
    for (std::int32_t p = 0; p < soil.points.size(); ++p) {
      EXPECT_LT((soil.points.v[p] - W * soil.points.x[p]).norm(), 1e-12);
      EXPECT_LT((soil.points.grad_v[p] - W).norm(), 1e-11);
      EXPECT_LT((soil.points.grad_a[p] - W * W).norm(), 1e-11);
    }
  });
}

}  // namespace
}  // namespace gabion::test::test_tpic
