// SPDX-License-Identifier: BSD-3-Clause
// Stresses of substeps: each one goes on from the state that the one before it found.
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>

#include "common/mechanics/tensor_functions.hpp"
#include "mpm_solver/stress/internal_forces.hpp"
#include "tests/unit/mpm/soil_patch.hpp"

namespace gabion::test::test_material_path {
namespace {

constexpr double lambda = 2e4, mu = 1e4, friction_angle = 0.6, dilation_angle = 0.1;

template <int dim>
MaterialLaw<dim> softening_soil() {
  const Strength peak{300, std::sin(friction_angle), std::sin(dilation_angle)};
  const Strength residual{20, std::sin(0.4), 0};
  return SofteningSoil<dim>(
      {.lambda = lambda,
       .mu = mu,
       .curve = StrengthCurve(ExponentialCurve{.peak = peak, .residual = residual, .scale = 0.5})});
}

template <int dim>
std::vector<MaterialLaw<dim>> plastic_laws() {
  const MohrCoulombParameters soil{.lambda = lambda,
                                   .mu = mu,
                                   .friction_angle = friction_angle,
                                   .dilation_angle = dilation_angle,
                                   .cohesion = 50};
  MohrCoulombParameters cut_off = soil;
  cut_off.tension_cutoff = 20;
  return {MohrCoulomb<dim>(soil), MohrCoulomb<dim>(cut_off),
          Tresca<dim>({.lambda = lambda, .mu = mu, .cohesion = 300}),
          DruckerPrager<dim>({.lambda = lambda,
                              .mu = mu,
                              .friction_angle = friction_angle,
                              .dilation_angle = dilation_angle,
                              .cohesion = 50}),
          softening_soil<dim>()};
}

/// Points of a box that yield everywhere in a few substeps.
template <int dim>
struct Path {
  SoilPatch<dim> soil;
  mpm::TrialPoints<dim> trial;
  mpm::MaterialPath<dim> path;
  mpm::StepContext<dim> context;
  std::optional<mpm::InternalForces<dim>> internal;

  Path(CellType type, const MaterialLaw<dim>& law, bool averaged) : soil(type, 2) {
    soil.fill(type == CellType::tri3 ? 3 : type == CellType::tet4 ? 4 : 1 << dim);
    soil.bodies = {{"soil", {"", 1, law}}};
    if (averaged && num_nodes(type) == dim + 1) {
      soil.grid.patches = mpm::join_cells(soil.mesh, soil.grid.stored->locator);
    }
    for (auto& state : soil.points.history) state.e.template head<3>().setConstant(-0.02);
    soil.to_grid();
    if (remembers_internal(law)) mpm::add_internal(soil.points);
    path = {.history = soil.points.history,
            .internal = soil.points.internal,
            .variables = {},
            .F = {}};
    context.grid = &soil.grid;
    internal.emplace(mpm::StressParts<dim>{.bodies = soil.bodies,
                                           .points = soil.points,
                                           .weights = soil.weights,
                                           .nodes = soil.nodes,
                                           .trial = trial,
                                           .path = &path,
                                           .context = &context},
                     0.5, 0, averaged);
  }
  /// An even deformation: what F-bar averages is the same at all points.
  std::vector<double> even_du(const Matrix<dim>& H) const {
    std::vector<double> du(soil.num_dofs());
    for (std::int32_t i = 0; i < soil.nodes.size(); ++i) {
      Eigen::Map<Vector<dim>>(du.data() + std::ptrdiff_t{i} * dim) = H * soil.nodes.x[i];
    }
    return du;
  }
  void evaluate(const std::vector<double>& du) {
    mpm::RefusedPoint worst;
    ASSERT_TRUE(internal->evaluate(du, nullptr, worst));
  }
};

template <int dim>
Matrix<dim> random_gradient(Random& random, double size) {
  Matrix<dim> H;
  for (int k = 0; k < dim * dim; ++k) H.data()[k] = size * random();
  return H;
}

template <int dim>
void check_path(CellType type, const MaterialLaw<dim>& law, bool averaged) {
  Path<dim> soil(type, law, averaged);
  const auto& weights = soil.soil.weights;
  MaterialState<dim> state = soil.soil.points.history[0];
  const bool remembers = remembers_internal(law);
  PointContext at_point = soil.context.of_point(soil.soil.points, 0);
  Matrix<dim> F = Matrix<dim>::Identity();
  for (int k = 0; k < 5; ++k) {
    const Matrix<dim> before = F;
    F += random_gradient<dim>(soil.soil.random, 0.05);
    if (k == 3) F += 0.2 * Matrix<dim>::Identity();  // opens a gap, which the next one closes
    soil.evaluate(soil.even_du(F - Matrix<dim>::Identity()));
    StressUpdate<dim> found;
    ASSERT_TRUE(update(LawInStep<MaterialLaw<dim>, dim>{law, at_point},
                       Matrix<dim>(F * before.inverse() - Matrix<dim>::Identity()), state, found,
                       static_cast<Tangent<dim>*>(nullptr)));
    state = found.state;
    if (remembers) at_point.internal = found.internal;
    for (std::size_t e = 0; e < soil.trial.tau.size(); ++e) {
      const auto& of_point = soil.trial.history[e];
      EXPECT_LT((soil.trial.tau[e] - found.tau).norm(), 1e-11 * mu);
      EXPECT_LT((of_point.e - state.e).norm(), 1e-13);
      EXPECT_NEAR(of_point.plastic_strain, state.plastic_strain, 1e-12);
      EXPECT_NEAR(of_point.gap, state.gap, 1e-13);
      EXPECT_NEAR(soil.trial.J_ratio[e], F.determinant(), 1e-13);
      const auto& on_path = soil.path.history[weights.point[e]];
      const Symmetric<dim> again = push_forward<dim>(F - Matrix<dim>::Identity(), on_path.e);
      EXPECT_LT((again - of_point.e).norm(), 1e-13);
      if (!remembers) continue;
      EXPECT_LT((soil.trial.internal[e] - at_point.internal).norm(), 1e-11);
      EXPECT_EQ(soil.path.internal[weights.point[e]], soil.trial.internal[e]);
    }
  }
  EXPECT_GT(state.plastic_strain, 0.05);
  if (remembers) {
    EXPECT_GT(at_point.internal[0], 0.02);
    EXPECT_GT(at_point.internal[1], 0.01);
  }
}

TEST(MaterialPath, substeps_go_on_from_each_other) {
  for_each_cell_type([]<int dim>(CellType type) {
    for (const auto& law : plastic_laws<dim>()) {
      check_path<dim>(type, law, false);
      check_path<dim>(type, law, true);
    }
  });
}

/// A result that does not depend on the path is found as without it, to the bit.
TEST(MaterialPath, elastic_states_stay) {
  const MaterialLaw<2> stiff = MohrCoulomb<2>(lambda, mu, friction_angle, dilation_angle, 1e9);
  for (const MaterialLaw<2>& law : {stiff, MaterialLaw<2>(NeoHookean<2>{lambda, mu})}) {
    Path<2> soil(CellType::quad4, law, true);
    const auto start = soil.path.history;
    const auto du = soil.soil.random.values(soil.soil.num_dofs(), 0.02);
    soil.evaluate(soil.soil.random.values(soil.soil.num_dofs(), 0.02));
    soil.evaluate(du);
    const auto on_path = soil.internal->forces();
    for (std::size_t p = 0; p < start.size(); ++p) EXPECT_EQ(soil.path.history[p].e, start[p].e);
    soil.path.history.clear();
    soil.internal->forget();
    soil.evaluate(du);
    EXPECT_EQ(on_path, soil.internal->forces());
  }
}

}  // namespace
}  // namespace gabion::test::test_material_path
