// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <map>
#include <optional>

#include "mpm_solver/stress/internal_forces.hpp"
#include "tests/support/check_tangent.hpp"
#include "tests/unit/mpm/soil_patch.hpp"

namespace gabion::test::test_averaged_forces {
namespace {

using Eigen::VectorXd;

/// Internal forces of a body in a box, with volumes and stresses that differ from point to point.
template <int dim>
struct AveragedSoil {
  SoilPatch<dim> soil;
  const Vector<dim>* held_normal = nullptr;
  mpm::TrialPoints<dim> trial;
  std::optional<mpm::InternalForces<dim>> internal;
  BlockMatrix<dim> K;

  /// @param squeeze  elastic b = 1 - squeeze at the start, give or take a fifth
  /// @param normal  see StressParts::held_normal
  AveragedSoil(CellType type, const MaterialLaw<dim>& law, double squeeze, bool averaged = true,
               const Vector<dim>* normal = nullptr)
      : soil(type, 2), held_normal(normal) {
    soil.fill(type == CellType::tri3 ? 3 : type == CellType::hex8 ? 8 : 4);
    prepare(type, law, squeeze, averaged);
  }
  /// Soil under splines on 4^dim cells, whose regular points are then moved.
  template <class Place>
  AveragedSoil(const MaterialLaw<dim>& law, double squeeze, const Place& place)
      : soil(dim == 2 ? CellType::quad4 : CellType::hex8, 4, mpm::Basis::bspline) {
    soil.grid.splits_border = true;
    soil.fill(dim == 2 ? 4 : 8);
    for (auto& x : soil.points.x) x = place(x);
    prepare(CellType::quad4, law, squeeze, true);
  }
  void prepare(CellType type, const MaterialLaw<dim>& law, double squeeze, bool averaged) {
    soil.bodies = {{"soil", {"", 1, law}}};
    if (averaged && (type == CellType::tri3 || type == CellType::tet4)) {
      soil.grid.patches = mpm::join_cells(soil.mesh, soil.grid.stored->locator);
    }
    auto& points = soil.points;
    for (std::int32_t p = 0; p < points.size(); ++p) {
      points.J[p] = 1 + 0.1 * soil.random();
      points.history[p].e.template head<3>().setConstant(-squeeze * (1 + 0.2 * soil.random()));
    }
    soil.to_grid();
    const mpm::StressParts<dim> parts{.bodies = soil.bodies,
                                      .points = points,
                                      .weights = soil.weights,
                                      .nodes = soil.nodes,
                                      .trial = trial,
                                      .held_normal = held_normal};
    internal.emplace(parts, 0.5, 0, averaged);
    soil.set_pattern(K);
  }

  VectorXd random_du(double size) {
    const auto values = soil.random.values(soil.num_dofs(), size);
    return Eigen::Map<const VectorXd>(values.data(), static_cast<Eigen::Index>(values.size()));
  }
  VectorXd forces(const VectorXd& du, BlockMatrix<dim>* matrix = nullptr) {
    mpm::RefusedPoint worst;
    EXPECT_TRUE(
        internal->evaluate({du.data(), static_cast<std::size_t>(du.size())}, matrix, worst));
    return Eigen::Map<const VectorXd>(internal->forces().data(), du.size());
  }
  Eigen::MatrixXd matrix(const VectorXd& du) {
    forces(du, &K);
    Eigen::MatrixXd dense(du.size(), du.size());
    for (Eigen::Index k = 0; k < du.size(); ++k) {
      const VectorXd unit = VectorXd::Unit(du.size(), k);
      K.multiply({unit.data(), static_cast<std::size_t>(du.size())},
                 {dense.col(k).data(), static_cast<std::size_t>(du.size())});
    }
    return dense;
  }
  double tangent_error_at(const VectorXd& du, double h) {
    return tangent_error([&](const VectorXd& x) { return forces(x); }, du, matrix(du), h);
  }
  double energy(const VectorXd& du) {
    forces(du);
    double sum = 0;
    for (std::size_t e = 0; e < trial.energy.size(); ++e) {
      sum += soil.points.V0[soil.weights.point[e]] * trial.energy[e];
    }
    return sum;
  }
  double volume(std::int32_t p) const { return soil.points.V0[p] * soil.points.J[p]; }
};

template <int dim>
Matrix<dim> gradient_at(const AveragedSoil<dim>& averaged, const mpm::CellGroup& group,
                        std::int32_t entry, const VectorXd& du) {
  const auto& [weights, nodes] = std::tie(averaged.soil.weights, averaged.soil.nodes);
  mpm::GroupDisplacements<dim> of_group;
  nodes.gather(weights.nodes_of(group), {du.data(), static_cast<std::size_t>(du.size())},
               of_group.data());
  return mpm::displacement_gradient(weights, entry, of_group.data());
}

TEST(AveragedForces, tangent_of_elastic_soil_is_exact_and_symmetric) {
  for_each_cell_type([]<int dim>(CellType type) {
    AveragedSoil<dim> averaged(type, NeoHookean<dim>{4e3, 3e3}, 0.05);
    const VectorXd du = averaged.random_du(0.03);
    EXPECT_LT(averaged.tangent_error_at(du, 1e-4), 1e-8) << name(type);
    const Eigen::MatrixXd K = averaged.matrix(du);
    EXPECT_LT((K - K.transpose()).norm(), 1e-13 * K.norm()) << name(type);
  });
}

TEST(AveragedForces, tangent_while_yielding_is_exact) {
  for_each_cell_type([]<int dim>(CellType type) {
    for (const double dilation_angle : {0.0, 0.1}) {
      AveragedSoil<dim> averaged(type, MohrCoulomb<dim>{4e3, 3e3, 0.3, dilation_angle, 0.0}, 0.05);
      const VectorXd du = averaged.random_du(0.015);
      EXPECT_LT(averaged.tangent_error_at(du, 1e-6), 1e-7) << name(type);
      averaged.forces(du);
      int yielding = 0;
      for (const auto& history : averaged.trial.history) yielding += history.plastic_strain > 0;
      EXPECT_GT(yielding, 0.2 * averaged.soil.points.size()) << name(type);
      EXPECT_LT(yielding, averaged.soil.points.size()) << name(type);
    }
  });
}

/// The forces do the work of the stress on the averaged strain: they derive from its energy.
TEST(AveragedForces, elastic_forces_are_the_derivative_of_the_energy) {
  for_each_cell_type([]<int dim>(CellType type) {
    AveragedSoil<dim> averaged(type, HenckyElastic<dim>{4e3, 3e3}, 0.05);
    const VectorXd du = averaged.random_du(0.03);
    const Eigen::MatrixXd slope = difference_tangent(
        [&](const VectorXd& x) { return VectorXd::Constant(1, averaged.energy(x)); }, du, 1e-4);
    const VectorXd f = averaged.forces(du);
    EXPECT_LT((slope.row(0).transpose() - f).norm(), 1e-9 * f.norm()) << name(type);
  });
}

/// Soil that walls hold in a plane, along an axis or not.
TEST(AveragedForces, forces_and_tangent_in_a_held_plane_are_exact) {
  for (const Vector<3>& axis : {Vector<3>(0, 0, 1), Vector<3>(0.36, -0.48, 0.8)}) {
    for (const CellType type : {CellType::hex8, CellType::tet4}) {
      AveragedSoil<3> elastic(type, HenckyElastic<3>{4e3, 3e3}, 0.05, true, &axis);
      const VectorXd du = elastic.random_du(0.03);
      EXPECT_LT(elastic.tangent_error_at(du, 1e-4), 1e-8) << name(type);
      const Eigen::MatrixXd K = elastic.matrix(du);
      EXPECT_LT((K - K.transpose()).norm(), 1e-13 * K.norm()) << name(type);
      const Eigen::MatrixXd slope = difference_tangent(
          [&](const VectorXd& x) { return VectorXd::Constant(1, elastic.energy(x)); }, du, 1e-4);
      const VectorXd f = elastic.forces(du);
      EXPECT_LT((slope.row(0).transpose() - f).norm(), 1e-9 * f.norm()) << name(type);
      AveragedSoil<3> sand(type, MohrCoulomb<3>{4e3, 3e3, 0.3, 0.1, 0.0}, 0.05, true, &axis);
      EXPECT_LT(sand.tangent_error_at(0.5 * du, 1e-6), 1e-7) << name(type);
    }
  }
}

/// Soil that ends amid the grid: each of the middle cells, 2^dim, has all its halves as groups.
template <int dim>
void check_halves() {
  const auto middle = [](const Vector<dim>& x) -> Vector<dim> {
    return Vector<dim>::Constant(0.25) + 0.5 * x;
  };
  AveragedSoil<dim> averaged(HenckyElastic<dim>{4e3, 3e3}, 0.05, middle);
  EXPECT_EQ(averaged.soil.weights.groups.size(), dim == 2 ? 16 : 64);
  const VectorXd du = averaged.random_du(0.01);
  const Eigen::MatrixXd K = averaged.matrix(du);
  EXPECT_LT((K - K.transpose()).norm(), 1e-13 * K.norm());
  EXPECT_LT(averaged.tangent_error_at(du, 1e-4), 1e-8);
  const Eigen::MatrixXd slope = difference_tangent(
      [&](const VectorXd& x) { return VectorXd::Constant(1, averaged.energy(x)); }, du, 1e-4);
  const VectorXd f = averaged.forces(du);
  EXPECT_LT((slope.row(0).transpose() - f).norm(), 1e-9 * f.norm());
}

TEST(AveragedForces, halves_at_the_border_of_splines) {
  check_halves<2>();
  check_halves<3>();
}

/// The motion of the spline beyond a level border that leaves the lines of the grid at rest,
/// u_i = r^(k - i) with r^2 + 6 r + 1 = 0, k the node beyond: means over whole cells at the border
/// are zero, those over halves bear half of what points would that each see their own volume.
TEST(AveragedForces, splines_beyond_the_border_are_not_free) {
  const auto lower_half = [](const Vector<2>& x) { return Vector<2>(x[0], 0.5 * x[1]); };
  AveragedSoil<2> averaged(HenckyElastic<2>{1e3, 1e-3}, 0, lower_half);
  const auto& nodes = averaged.soil.nodes;
  VectorXd du = VectorXd::Zero(static_cast<Eigen::Index>(averaged.soil.num_dofs()));
  for (std::int32_t i = 0; i < nodes.size(); ++i) {
    du[2 * i + 1] = 1e-5 * std::pow(std::sqrt(8.0) - 3, 3 - 4 * nodes.x[i][1]);
  }
  double own = 0;
  std::map<std::int32_t, double> of_cell, size;
  for (const auto& group : averaged.soil.weights.groups) {
    for (std::int32_t e = group.first; e < group.last; ++e) {
      const double change = gradient_at(averaged, group, e, du).trace();
      const double V0 = averaged.soil.points.V0[averaged.soil.weights.point[e]];
      own += 0.5e3 * V0 * change * change;
      of_cell[group.cell] += V0 * change;
      size[group.cell] += V0 * std::abs(change);
    }
  }
  for (std::int32_t cell = 4; cell < 8; ++cell) {
    EXPECT_LT(std::abs(of_cell[cell]), 1e-10 * size[cell]);
  }
  EXPECT_GT(averaged.energy(du), 0.4 * own);
}

TEST(AveragedForces, start_forces_are_those_of_no_motion) {
  for_each_cell_type([]<int dim>(CellType type) {
    AveragedSoil<dim> averaged(type, NeoHookean<dim>{4e3, 3e3}, 0.05);
    const VectorXd at_rest =
        averaged.forces(VectorXd::Zero(static_cast<Eigen::Index>(averaged.soil.num_dofs())));
    for (std::size_t e = 0; e < averaged.trial.tau.size(); ++e) {
      averaged.soil.points.tau[averaged.soil.weights.point[e]] = averaged.trial.tau[e];
    }
    const auto start = averaged.internal->start_forces();
    for (std::size_t k = 0; k < start.size(); ++k) {
      EXPECT_NEAR(start[k], at_rest[static_cast<Eigen::Index>(k)], 1e-13 * at_rest.norm());
    }
    EXPECT_GT(at_rest.norm(), 1) << name(type);
  });
}

/// One gradient everywhere leaves nothing to average.
TEST(AveragedForces, uniform_strain_of_uniform_soil_is_left_as_it_is) {
  for_each_cell_type([]<int dim>(CellType type) {
    const auto law = NeoHookean<dim>{4e3, 3e3};
    AveragedSoil<dim> averaged(type, law, 0), plain(type, law, 0, false);
    Matrix<dim> H;
    for (int k = 0; k < dim * dim; ++k) H(k / dim, k % dim) = 0.1 * averaged.soil.random();
    VectorXd du(static_cast<Eigen::Index>(averaged.soil.num_dofs()));
    for (std::int32_t i = 0; i < averaged.soil.nodes.size(); ++i) {
      du.segment<dim>(i * dim) = H * averaged.soil.node(i);
    }
    std::fill(averaged.soil.points.J.begin(), averaged.soil.points.J.end(), 1.0);
    const VectorXd f = averaged.forces(du), reference = plain.forces(du);
    EXPECT_LT((f - reference).norm(), 1e-12 * reference.norm()) << name(type);
  });
}

TEST(AveragedForces, have_no_resultant_and_no_moment) {
  for_each_cell_type([]<int dim>(CellType type) {
    AveragedSoil<dim> averaged(type, NeoHookean<dim>{4e3, 3e3}, 0.05);
    const VectorXd du = averaged.random_du(0.03), f = averaged.forces(du);
    ForceAndMoment<dim> sum;
    for (std::int32_t i = 0; i < averaged.soil.nodes.size(); ++i) {
      sum.add(averaged.soil.node(i) + du.segment<dim>(i * dim), f.segment<dim>(i * dim));
    }
    EXPECT_GT(sum.size, 10) << name(type);
    EXPECT_LT(sum.force.norm(), 1e-12 * sum.size) << name(type);
    EXPECT_LT(sum.moment.norm(), 1e-12 * sum.size) << name(type);
  });
}

/// The points of a group share its volume change; the volume of the group is that of its points'
/// own deformation.
TEST(AveragedForces, volume_is_shared_and_kept) {
  for_each_cell_type([]<int dim>(CellType type) {
    AveragedSoil<dim> averaged(type, NeoHookean<dim>{4e3, 3e3}, 0.05);
    const VectorXd du = averaged.random_du(0.05);
    averaged.forces(du);
    double spread = 0;
    for (const auto& group : averaged.soil.weights.groups) {
      double volume = 0, expected = 0;
      const double J_bar = averaged.trial.J_ratio[group.first];
      for (std::int32_t e = group.first; e < group.last; ++e) {
        const double V = averaged.volume(averaged.soil.weights.point[e]);
        const Matrix<dim> H = gradient_at(averaged, group, e, du);
        const double J = (Matrix<dim>::Identity() + H).determinant();
        EXPECT_NEAR(averaged.trial.J_ratio[e], J_bar, 1e-14) << name(type);
        volume += V * averaged.trial.J_ratio[e];
        expected += V * J;
        spread = std::max(spread, std::abs(J - J_bar));
      }
      EXPECT_NEAR(volume, expected, 1e-14 * expected) << name(type);
    }
    EXPECT_GT(spread, 0.01) << name(type);
  });
}

TEST(AveragedForces, a_point_that_is_squeezed_flat_is_found) {
  AveragedSoil<2> averaged(CellType::quad4, NeoHookean<2>{4e3, 3e3}, 0);
  VectorXd du = VectorXd::Zero(static_cast<Eigen::Index>(averaged.soil.num_dofs()));
  du[1] = 0.65;  // the lower left node goes above its upper neighbour
  mpm::RefusedPoint worst;
  EXPECT_FALSE(averaged.internal->evaluate({du.data(), static_cast<std::size_t>(du.size())},
                                           nullptr, worst));
  EXPECT_EQ(worst.point, 0);
}

}  // namespace
}  // namespace gabion::test::test_averaged_forces
