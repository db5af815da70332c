// SPDX-License-Identifier: BSD-3-Clause
// Points with laws of their own: forces, tangents, and all else that asks for stiffness.
#include <gtest/gtest.h>

#include <cmath>
#include <deque>
#include <optional>

#include "mpm_solver/small_cuts/ghost_stiffness.hpp"
#include "mpm_solver/stress/internal_forces.hpp"
#include "mpm_solver/stress/shared_volumes.hpp"
#include "mpm_solver/stress/yielding_points.hpp"
#include "tests/support/check_tangent.hpp"
#include "tests/unit/mpm/soil_patch.hpp"

namespace gabion::test::test_point_laws {
namespace {

using Eigen::VectorXd;

constexpr double lambda = 3, mu = 2;

/// A box of soil whose points have laws of their own.
template <int dim>
struct VaryingPatch {
  SoilPatch<dim> soil;
  std::deque<MaterialLaw<dim>> laws;
  std::vector<const MaterialLaw<dim>*> of_points;
  mpm::TrialPoints<dim> trial;
  BlockMatrix<dim> K;

  /// @param make  law of the point of this number, and of the body
  template <class Make>
  VaryingPatch(CellType type, const Make& make) : soil(type, 2) {
    soil.fill(type == CellType::tri3 ? 3 : type == CellType::hex8 ? 8 : 4);
    soil.bodies = {{"soil", {"", 1, make(0)}}};
    for (std::int32_t p = 0; p < soil.points.size(); ++p) {
      laws.push_back(make(p));
      of_points.push_back(&laws.back());
      soil.points.J[p] = 1 + 0.1 * soil.random();
      soil.points.history[p].e.template head<3>().setConstant(0.02 * soil.random() - 0.03);
    }
    soil.to_grid();
    soil.set_pattern(K);
  }
  mpm::StressParts<dim> parts() {
    return {.bodies = soil.bodies,
            .points = soil.points,
            .weights = soil.weights,
            .nodes = soil.nodes,
            .trial = trial,
            .laws = of_points};
  }
  VectorXd random_du(double size) {
    const auto values = soil.random.values(soil.num_dofs(), size);
    return Eigen::Map<const VectorXd>(values.data(), static_cast<Eigen::Index>(values.size()));
  }
  Eigen::MatrixXd dense(Eigen::Index n) {
    Eigen::MatrixXd matrix(n, n);
    for (Eigen::Index k = 0; k < n; ++k) {
      const VectorXd unit = VectorXd::Unit(n, k);
      K.multiply({unit.data(), static_cast<std::size_t>(n)},
                 {matrix.col(k).data(), static_cast<std::size_t>(n)});
    }
    return matrix;
  }
  /// Error of K at du, by differences of the forces.
  double tangent_error_at(const VectorXd& du, double h, bool averaged) {
    mpm::InternalForces<dim> internal(parts(), 0.5, 0, averaged);
    mpm::RefusedPoint worst;
    const auto forces = [&](const VectorXd& x, BlockMatrix<dim>* matrix) {
      EXPECT_TRUE(internal.evaluate({x.data(), static_cast<std::size_t>(x.size())}, matrix, worst));
      return VectorXd(Eigen::Map<const VectorXd>(internal.forces().data(), x.size()));
    };
    forces(du, &K);
    const Eigen::MatrixXd matrix = dense(du.size());
    return tangent_error([&](const VectorXd& x) { return forces(x, nullptr); }, du, matrix, h);
  }
};

template <int dim>
MaterialLaw<dim> elastic(std::int32_t p) {
  const double factor = 1 + 0.1 * (p % 7);
  return HenckyElastic<dim>{factor * lambda, factor * mu};
}

template <int dim>
MaterialLaw<dim> sand(std::int32_t p) {
  return MohrCoulomb<dim>({.lambda = lambda * (1 + 0.1 * (p % 3)),
                           .mu = mu * (1 + 0.1 * (p % 3)),
                           .friction_angle = 0.4 + 0.03 * (p % 5),
                           .dilation_angle = 0.05 * (p % 4),
                           .cohesion = 0.01 * (1 + p % 6)});
}

TEST(PointLaws, tangents_of_all_points) {
  for (const bool averaged : {false, true}) {
    VaryingPatch<2> quads(CellType::quad4, elastic<2>);
    EXPECT_LT(quads.tangent_error_at(quads.random_du(0.05), 1e-4, averaged), 1e-8);
    VaryingPatch<3> bricks(CellType::hex8, elastic<3>);
    EXPECT_LT(bricks.tangent_error_at(bricks.random_du(0.05), 1e-4, averaged), 1e-8);
    VaryingPatch<2> plastic(CellType::quad4, sand<2>);
    EXPECT_LT(plastic.tangent_error_at(plastic.random_du(0.02), 1e-6, averaged), 1e-7);
    int yielded = 0;
    for (const YieldRegion region : plastic.trial.region) yielded += region != YieldRegion::elastic;
    EXPECT_GT(yielded, 4);
  }
  VaryingPatch<2> triangles(CellType::tri3, elastic<2>);
  EXPECT_LT(triangles.tangent_error_at(triangles.random_du(0.05), 1e-4, false), 1e-8);
}

/// The stress of each point is that of its own law alone.
TEST(PointLaws, stresses_are_those_of_the_laws) {
  VaryingPatch<2> patch(CellType::quad4, sand<2>);
  mpm::InternalForces<2> internal(patch.parts(), 0.5, 0, false);
  const VectorXd du = patch.random_du(0.02);
  mpm::RefusedPoint worst;
  ASSERT_TRUE(internal.evaluate({du.data(), static_cast<std::size_t>(du.size())}, nullptr, worst));
  const auto& weights = patch.soil.weights;
  for (const auto& group : weights.groups) {
    mpm::GroupDisplacements<2> of_group;
    patch.soil.nodes.gather(weights.nodes_of(group),
                            {du.data(), static_cast<std::size_t>(du.size())}, of_group.data());
    for (std::int32_t e = group.first; e < group.last; ++e) {
      const std::int32_t p = weights.point[e];
      const Matrix<2> H = mpm::displacement_gradient<2>(weights, e, of_group.data());
      StressUpdate<2> alone;
      ASSERT_TRUE(update<2>(patch.laws[p], H, patch.soil.points.history[p], alone, nullptr));
      EXPECT_LT((patch.trial.tau[e] - alone.tau).norm(), 1e-13);
    }
  }
}

/// With half of its stiffness at all points, ghost stiffness is half of that of the body.
TEST(PointLaws, ghost_stiffness_follows_the_points) {
  SoilPatch<2> soil(CellType::quad4, 3);
  soil.scatter(20);
  for (double& V0 : soil.points.V0) V0 = 0.03 / 9;
  soil.bodies = {{"soil", {"", 1, HenckyElastic<2>{lambda, mu}}}};
  soil.to_grid();
  const MaterialLaw<2> half = HenckyElastic<2>{lambda / 2, mu / 2};
  const std::vector<const MaterialLaw<2>*> laws(soil.points.size(), &half);
  const auto du = soil.random.values(soil.num_dofs(), 1e-3);
  const auto forces = [&](std::span<const MaterialLaw<2>* const> of_points) {
    mpm::GhostStiffness<2> ghost(soil.grid, soil.bodies, 0.05);
    ghost.find_facets(soil.owners(), soil.points, soil.weights, {}, of_points);
    ghost.begin_step(soil.nodes);
    EXPECT_GT(ghost.num_facets(), 3);
    std::vector<double> r(soil.num_dofs(), 0.0);
    ghost.add_forces(du, r, nullptr);
    return r;
  };
  const auto whole = forces({}), weak = forces(laws);
  for (std::size_t k = 0; k < whole.size(); ++k) EXPECT_DOUBLE_EQ(weak[k], whole[k] / 2);
}

/// The regularisation of points that yield takes the stiffness of each.
TEST(PointLaws, regularisation_follows_the_points) {
  VaryingPatch<2> patch(CellType::quad4,
                        [](std::int32_t) { return MaterialLaw<2>(elastic<2>(0)); });
  const auto stiffness = [&](double factor) {
    for (auto& law : patch.laws) law = HenckyElastic<2>{factor * lambda, factor * mu};
    mpm::YieldingPoints<2> yielding;
    yielding.add(std::vector<YieldRegion>(patch.soil.points.size(), YieldRegion::shear));
    patch.K.set_zero();
    yielding.add_stiffness(0.1, patch.parts(), patch.K);
    return patch.dense(static_cast<Eigen::Index>(patch.soil.num_dofs()));
  };
  const Eigen::MatrixXd once = stiffness(1), thrice = stiffness(3);
  EXPECT_GT(once.norm(), 0.1);
  EXPECT_LT((thrice - 3 * once).norm(), 1e-13 * thrice.norm());
}

/// Shared volumes give each point the stress of its own law.
TEST(PointLaws, shared_volumes_have_the_stress_of_each_law) {
  VaryingPatch<2> patch(CellType::quad4, elastic<2>);
  auto& points = patch.soil.points;
  mpm::share_volumes<2>(patch.soil.owners(), patch.soil.bodies, points, patch.of_points);
  for (std::int32_t p = 0; p < points.size(); ++p) {
    const double factor = 1 + 0.1 * (p % 7);
    const double strain =
        0.5 * (std::log1p(points.history[p].e[0]) + std::log1p(points.history[p].e[1]) +
               std::log1p(points.history[p].e[2]));
    EXPECT_NEAR(points.tau[p].head<3>().sum(), factor * (3 * lambda + 2 * mu) * strain, 1e-12);
  }
}

}  // namespace
}  // namespace gabion::test::test_point_laws
