// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "tests/unit/mpm/soil_patch.hpp"

namespace gabion::test::test_transfer {
namespace {

constexpr double round_off = 1e-13;

template <int dim>
mpm::NodalMotion<dim> random_motion(SoilPatch<dim>& soil) {
  mpm::NodalMotion<dim> motion;
  for (std::int32_t i = 0; i < soil.nodes.size(); ++i) {
    motion.du.push_back(0.01 * soil.random.template vector<dim>());
    motion.v_new.push_back(soil.random.template vector<dim>());
    motion.a_new.push_back(soil.random.template vector<dim>());
  }
  return motion;
}

template <int dim>
Vector<dim> momentum(const mpm::MaterialPoints<dim>& points) {
  Vector<dim> sum = Vector<dim>::Zero();
  for (std::int32_t p = 0; p < points.size(); ++p) sum += points.m[p] * points.v[p];
  return sum;
}

template <int dim>
Vector<dim> momentum(const mpm::GridNodes<dim>& nodes, const std::vector<Vector<dim>>& v) {
  Vector<dim> sum = Vector<dim>::Zero();
  for (std::int32_t i = 0; i < nodes.size(); ++i) sum += nodes.m[i] * v[i];
  return sum;
}

TEST(PointsToGrid, conserves_mass_momentum_and_angular_momentum) {
  for_each_basis([]<int dim>(CellType type, mpm::Basis basis) {
    SoilPatch<dim> soil(type, 3, basis);
    soil.scatter(200);
    soil.to_grid();
    double mass = 0;
    ForceAndMoment<dim> points, nodes, points_a, nodes_a;
    for (std::int32_t p = 0; p < 200; ++p) {
      const double m = soil.points.m[p];
      mass += m;
      points.add(soil.points.x[p], m * soil.points.v[p]);
      points_a.add(soil.points.x[p], m * soil.points.a[p]);
    }
    for (std::int32_t i = 0; i < soil.nodes.size(); ++i) {
      const double m = soil.nodes.m[i];
      mass -= m;
      nodes.add(soil.node(i), m * soil.nodes.v[i]);
      nodes_a.add(soil.node(i), m * soil.nodes.a[i]);
    }
    EXPECT_NEAR(mass, 0, 1e-11);
    EXPECT_LT((points.force - nodes.force).norm(), round_off * points.size);
    EXPECT_LT((points.moment - nodes.moment).norm(), round_off * points.size);
    EXPECT_LT((points_a.force - nodes_a.force).norm(), round_off * points_a.size);
    EXPECT_LT((points_a.moment - nodes_a.moment).norm(), round_off * points_a.size);
  });
}

TEST(PointsToGrid, uniform_velocity_is_reproduced_also_by_weightless_nodes) {
  for_each_basis([]<int dim>(CellType type, mpm::Basis basis) {
    SoilPatch<dim> soil(type, 3, basis);
    soil.scatter(20);
    soil.add(Vector<dim>::Constant(1.0 / 3));  // on a node: the others of its cell get no weight
    const Vector<dim> v = soil.random.template vector<dim>();
    std::fill(soil.points.v.begin(), soil.points.v.end(), v);
    std::fill(soil.points.a.begin(), soil.points.a.end(), -v);
    soil.to_grid();
    for (std::int32_t i = 0; i < soil.nodes.size(); ++i) {
      EXPECT_LT((soil.nodes.v[i] - v).norm(), 1e-14) << name(type);
      EXPECT_LT((soil.nodes.a[i] + v).norm(), 1e-14) << name(type);
    }
  });
}

/// A point on a node, an edge, a face of a cell or an outer wall belongs to one cell; the nodes
/// that it does not weigh on move with the points of their cells.
TEST(PointsToGrid, points_on_nodes_edges_and_walls) {
  for_each_basis([]<int dim>(CellType type, mpm::Basis basis) {
    const double third = 1.0 / 3;
    for (const double first : {0.0, third, 0.5, 1.0}) {
      for (const double second : {0.0, 2 * third, 1.0}) {
        SoilPatch<dim> soil(type, 3, basis);
        Vector<dim> x = Vector<dim>::Constant(1.0);
        x[0] = first;
        x[1] = second;
        soil.add(x);
        soil.to_grid();
        double mass = 0;
        for (std::int32_t i = 0; i < soil.nodes.size(); ++i) {
          mass += soil.nodes.m[i];
          EXPECT_LT((soil.nodes.v[i] - soil.points.v[0]).norm(), 1e-12)
              << name(type) << x.transpose();
          EXPECT_LT((soil.nodes.a[i] - soil.points.a[0]).norm(), 1e-12);
        }
        EXPECT_NEAR(mass, soil.points.m[0], 1e-14);
        if (basis == mpm::Basis::linear) {
          EXPECT_EQ(soil.nodes.size(), soil.mesh.nodes_per_cell());
        }
      }
    }
  });
}

TEST(GridToPoints, changes_the_momentum_by_the_impulse_of_the_nodes) {
  for_each_basis([]<int dim>(CellType type, mpm::Basis basis) {
    for (const double pic_share : {0.0, 0.3, 1.0}) {
      SoilPatch<dim> soil(type, 3, basis);
      soil.scatter(200);
      soil.to_grid();
      const auto motion = random_motion(soil);
      const Vector<dim> before = momentum(soil.points);
      grid_to_points(soil.nodes, motion, soil.weights, pic_share, soil.points);
      const Vector<dim> impulse =
          momentum(soil.nodes, motion.v_new) - momentum(soil.nodes, soil.nodes.v);
      EXPECT_LT((momentum(soil.points) - before - impulse).norm(), round_off * 400);
    }
  });
}

TEST(GridToPoints, points_follow_a_linear_displacement_exactly) {
  for_each_basis([]<int dim>(CellType type, mpm::Basis basis) {
    SoilPatch<dim> soil(type, 3, basis);
    soil.scatter(50);
    soil.to_grid();
    auto motion = random_motion(soil);
    Matrix<dim> slope;
    for (int d = 0; d < dim; ++d) slope.col(d) = 0.1 * soil.random.template vector<dim>();
    for (std::int32_t i = 0; i < soil.nodes.size(); ++i) motion.du[i] = slope * soil.node(i);
    const auto before = soil.points.x;
    grid_to_points(soil.nodes, motion, soil.weights, 0, soil.points);
    for (std::size_t p = 0; p < before.size(); ++p) {
      EXPECT_LT((soil.points.x[p] - before[p] - slope * before[p]).norm(), 1e-15);
      EXPECT_LT((soil.points.u[p] - slope * before[p]).norm(), 1e-15);
    }
  });
}

TEST(GridToPoints, nothing_happens_in_flip_and_pic_takes_its_share) {
  for_each_basis([]<int dim>(CellType type, mpm::Basis basis) {
    for (const double pic_share : {0.0, 0.2, 1.0}) {
      SoilPatch<dim> soil(type, 3, basis);
      soil.scatter(50);
      soil.to_grid();
      mpm::NodalMotion<dim> still;
      still.du.assign(soil.nodes.m.size(), Vector<dim>::Zero());
      still.v_new = soil.nodes.v;
      still.a_new = soil.nodes.a;
      const auto before = soil.points;
      grid_to_points(soil.nodes, still, soil.weights, pic_share, soil.points);
      EXPECT_EQ(soil.points.x, before.x);
      EXPECT_EQ(soil.points.v == before.v, pic_share == 0);
      for (const auto& group : soil.weights.groups) {
        const auto grid_nodes = soil.weights.nodes_of(group);
        for (std::int32_t e = group.first; e < group.last; ++e) {
          const std::int32_t p = soil.weights.point[e];
          Vector<dim> v = Vector<dim>::Zero(), a = Vector<dim>::Zero();
          for (int i = 0; i < soil.weights.num_nodes(e); ++i) {
            const std::int32_t node = soil.nodes.active[grid_nodes[soil.weights.local_of(e)[i]]];
            v += soil.weights.N_of(e)[i] * soil.nodes.v[node];
            a += soil.weights.N_of(e)[i] * soil.nodes.a[node];
          }
          EXPECT_LT((soil.points.v[p] - (1 - pic_share) * before.v[p] - pic_share * v).norm(),
                    1e-15);
          EXPECT_LT((soil.points.a[p] - a).norm(), 1e-15);
        }
      }
    }
  });
}

/// Gauss points of the cells themselves integrate volume and, on bricks, all of the basis.
TEST(LayPoints, volume_mass_and_shares_of_ranks) {
  for_each_cell_type([]<int dim>(CellType type) {
    for (const int count : {1, type == CellType::tri3               ? 3
                               : dim == 2 || type == CellType::tet4 ? 4
                                                                    : 8}) {
      SoilPatch<dim> whole(type), parts(type);
      whole.fill(count, 7);
      double volume = 0, mass = 0;
      for (std::int32_t p = 0; p < whole.points.size(); ++p) {
        volume += whole.points.V0[p];
        mass += whole.points.m[p];
        EXPECT_EQ(whole.points.id[p], p);
      }
      EXPECT_NEAR(volume, 1, 1e-13);
      EXPECT_NEAR(mass, 7, 1e-12);
      std::vector<Vector<dim>> x;
      for (int part = 0; part < 3; ++part) {
        mpm::MaterialPoints<dim> share;
        const auto total =
            mpm::lay_points<dim>({parts.mesh, count, Vector<dim>::Zero()}, 7,
                                 {.first_id = 100, .part = part, .num_parts = 3}, share);
        EXPECT_EQ(total, whole.points.size());
        EXPECT_EQ(share.id.front(), 100 + static_cast<std::int64_t>(x.size()));
        x.insert(x.end(), share.x.begin(), share.x.end());
      }
      EXPECT_EQ(x, whole.points.x);
    }
  });
}

/// Taking points out takes them out of every field, in order; `id` says which they were.
TEST(MaterialPoints, every_field_loses_the_points_that_are_removed) {
  SoilPatch<2> soil(CellType::quad4, 2, mpm::Basis::gimp);
  soil.scatter(6);
  add_gradients(soil.points);
  soil.points.water.assign(6, 0.4);
  soil.points.internal.assign(6, InternalState(1, 2));
  soil.points.variables.assign(6, mpm::StateVariables::Zero());
  soil.points.parameters.assign(6, mpm::VaryingParameters::Zero());
  const auto before = soil.points;
  const std::vector<std::int32_t> which = {0, 3, 4};
  mpm::remove_points<2>(which, soil.points);
  EXPECT_EQ(soil.points.id, (std::vector<std::int64_t>{1, 2, 5}));
  EXPECT_EQ(soil.points.body_starts, (std::vector<std::int32_t>{0, 3}));
  EXPECT_EQ(soil.points.x[1], before.x[2]);
  EXPECT_EQ(soil.points.half_length[2], before.half_length[5]);
  mpm::for_each_field<2>([&](const char* field, auto member) {
    EXPECT_EQ((soil.points.*member).size(), 3u) << field;
  });
}

}  // namespace
}  // namespace gabion::test::test_transfer
