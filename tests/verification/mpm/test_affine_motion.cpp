// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "tests/support/verification_row.hpp"
#include "tests/verification/elastic_laws.hpp"
#include "tests/verification/mpm/driven_block.hpp"

namespace gabion::test {
namespace {

constexpr double E = 1e6, nu = 0.3;
const Lame lame(E, nu);

struct Kind {
  CellType type;
  int points_per_cell;
  const char* name;
};
template <int dim>
std::vector<Kind> kinds() {
  if constexpr (dim == 2) return {{CellType::tri3, 3, "tri3"}, {CellType::quad4, 4, "quad4"}};
  return {{CellType::tet4, 4, "tet4"}, {CellType::hex8, 8, "hex8"}};
}

template <int dim>
Matrix<dim> stretch_and_shear() {
  Matrix<3> F;
  F << 1.2, 0.15, -0.05, 0.1, 0.9, 0.2, 0.07, -0.1, 1.05;
  return F.topLeftCorner<dim, dim>();
}

/// Largest component of tau - exact over all points, by E.
template <int dim>
double stress_error(const DrivenBlock<dim>& block, const Matrix<3>& exact) {
  double error = 0;
  for (const auto& tau : block.soil.points.tau) {
    error = std::max(error, (full<dim>(tau) - exact).cwiseAbs().maxCoeff() / E);
  }
  return error;
}

void error_row(const std::string& what, double computed, double bound) {
  verify({.id = "V1",
          .what = what,
          .exact = 0,
          .computed = computed,
          .measure = Measure::absolute_error,
          .bound = bound});
}

/// Points fill the grid; one affine step. Uniform stress, no force on inner nodes.
template <int dim>
void patch() {
  const Matrix<dim> H = stretch_and_shear<dim>() - Matrix<dim>::Identity();
  double stress = 0, force = 0;
  for (const Kind& kind : kinds<dim>()) {
    for (const std::string law : {"neo_hookean", "hencky_elastic"}) {
      constexpr int cells = 4;
      DrivenBlock<dim> block(kind.type, cells, elastic_law<dim>(law, lame), Vector<dim>::Zero(),
                             Vector<dim>::Ones(), cells, kind.points_per_cell);
      block.move(H, Vector<dim>::Zero());
      stress = std::max(
          stress, stress_error<dim>(block, exact_stress<dim>(law, lame, stretch_and_shear<dim>())));
      const double area = std::pow(1.0 / cells, dim - 1);
      for (std::int32_t i = 0; i < block.soil.nodes.size(); ++i) {
        const auto x = block.soil.node(i).array();
        if ((x < 0.01).any() || (x > 0.99).any()) continue;
        for (int d = 0; d < dim; ++d) {
          force = std::max(force, std::abs(block.f_int[i * dim + d]) / (E * area));
        }
      }
    }
  }
  const std::string where = dim == 2 ? ", MPM tri3, quad4" : ", MPM tet4, hex8";
  error_row("patch: stress over E" + where, stress, 1e-13);
  error_row("patch: force on inner nodes over E h^" + std::to_string(dim - 1) + where, force,
            1e-13);
}

TEST(V1_AffineMotion, patch_2d) {
  patch<2>();
}
TEST(V1_AffineMotion, patch_3d) {
  patch<3>();
}

template <int dim>
Matrix<dim> rotation(double angle) {
  if constexpr (dim == 2) {
    return Eigen::Rotation2Dd(angle).toRotationMatrix();
  } else {
    return Eigen::AngleAxisd(angle, Vector<3>(1, 2, 3).normalized()).toRotationMatrix();
  }
}

/// A strained block turns by 360 degrees through the cells of the grid: tau = R tau_0 R^T.
template <int dim>
void rotate() {
  constexpr int steps = 72;
  const Vector<dim> centre = Vector<dim>::Constant(0.5);
  const Matrix<dim> F0 = stretch_and_shear<dim>();
  const Matrix<dim> turn = rotation<dim>(2 * M_PI / steps) - Matrix<dim>::Identity();
  double drift = 0, path = 0;
  for (const Kind& kind : kinds<dim>()) {
    for (const std::string law : {"neo_hookean", "hencky_elastic"}) {
      DrivenBlock<dim> block(kind.type, 7, elastic_law<dim>(law, lame), Vector<dim>::Constant(0.35),
                             Vector<dim>::Constant(0.65), 2, kind.points_per_cell);
      block.move(F0 - Matrix<dim>::Identity(), centre);
      const auto before = block.soil.points.x;
      for (int n = 1; n <= steps; ++n) {
        block.move(turn, centre);
        const Matrix<dim> R = rotation<dim>(2 * M_PI * n / steps);
        drift = std::max(drift, stress_error<dim>(block, exact_stress<dim>(law, lame, R * F0)));
      }
      for (std::size_t p = 0; p < before.size(); ++p) {
        path = std::max(path, (block.soil.points.x[p] - before[p]).norm());
      }
    }
  }
  const std::string where = dim == 2 ? ", MPM tri3, quad4" : ", MPM tet4, hex8";
  error_row("rotation by 360 deg, 72 steps: stress drift over E" + where, drift, 1e-10);
  error_row("rotation by 360 deg, 72 steps: position [m]" + where, path, 1e-10);
}

TEST(V1_AffineMotion, rotation_2d) {
  rotate<2>();
}
TEST(V1_AffineMotion, rotation_3d) {
  rotate<3>();
}

/// Simple shear to gamma = 4 in 80 steps, u_x = gamma Y: with the deformation gradient of each step
/// dF = 1 + dgamma e_x (x) e_y the product is the exact F.
template <int dim>
void shear() {
  constexpr int steps = 80;
  constexpr double gamma = 4;
  double error = 0;
  for (const Kind& kind : kinds<dim>()) {
    for (const std::string law : {"neo_hookean", "hencky_elastic"}) {
      Vector<dim> low = Vector<dim>::Constant(0.3), high = Vector<dim>::Constant(0.4);
      low[0] = 0.05;
      high[0] = 0.15;
      DrivenBlock<dim> block(kind.type, 10, elastic_law<dim>(law, lame), low, high, 1,
                             kind.points_per_cell);
      Vector<dim> still = Vector<dim>::Constant(0.3);
      Matrix<dim> H = Matrix<dim>::Zero(), F = Matrix<dim>::Identity();
      H(0, 1) = gamma / steps;
      for (int n = 1; n <= steps; ++n) {
        block.move(H, still);
        F(0, 1) = gamma * n / steps;
        error = std::max(error, stress_error<dim>(block, exact_stress<dim>(law, lame, F)));
      }
      if (kind.type == CellType::tri3 || kind.type == CellType::tet4) continue;  // in the last row
      // tau_xy = 4 mu asinh(gamma / 2) / sqrt(gamma^2 + 4) of Hencky's law, mu gamma of the other
      const double tau_xy =
          law == "neo_hookean" ? lame.mu * gamma
                               : 4 * lame.mu * std::asinh(gamma / 2) / std::sqrt(gamma * gamma + 4);
      verify({.id = "V1",
              .what = "simple shear to gamma = 4: tau_xy, " + law + ", MPM " + kind.name,
              .exact = tau_xy,
              .computed = full<dim>(block.soil.points.tau.front())(0, 1),
              .bound = 1e-12,
              .unit = "Pa"});
    }
  }
  const std::string where = dim == 2 ? ", MPM tri3, quad4" : ", MPM tet4, hex8";
  error_row("simple shear to gamma = 4, 80 steps: stress over E" + where, error, 1e-11);
}

TEST(V1_AffineMotion, simple_shear_2d) {
  shear<2>();
}
TEST(V1_AffineMotion, simple_shear_3d) {
  shear<3>();
}

}  // namespace
}  // namespace gabion::test
