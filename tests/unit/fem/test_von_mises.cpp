// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <random>

#include "common/mechanics/materials/elastic.hpp"
#include "fem_solver/materials/elastic_log_stress.hpp"
#include "fem_solver/materials/von_mises.hpp"
#include "tests/support/check_tangent.hpp"
#include "tests/support/mpi_main.hpp"

namespace gabion::test::test_von_mises {
namespace {

using fem::Hardening;
using fem::VonMises;

constexpr double E = 200e9, nu = 0.3, yield_stress = 250e6;
constexpr double lambda = E * nu / ((1 + nu) * (1 - 2 * nu)), mu = E / (2 * (1 + nu));

template <int dim>
VonMises<dim> steel(double isotropic, double kinematic) {
  return {.lambda = lambda,
          .mu = mu,
          .kinematic_modulus = kinematic,
          .hardening = Hardening::linear(yield_stress, isotropic)};
}

/// A point that keeps its accepted history.
template <int dim>
struct Point {
  VonMises<dim> law;
  std::vector<double> history = std::vector<double>(VonMises<dim>::history_size, 0.0);

  StressUpdate<dim> at(const Matrix<dim>& H, Tangent<dim>* A = nullptr) const {
    std::vector<double> unused(history);
    StressUpdate<dim> out;
    EXPECT_TRUE(law.update(H, history, unused, out, A));
    return out;
  }
  void accept(const Matrix<dim>& H) {
    std::vector<double> next(history);
    StressUpdate<dim> out;
    ASSERT_TRUE(law.update(H, history, next, out, nullptr));
    history = next;
  }
};

template <int dim>
Matrix<dim> random_gradient(std::mt19937& random, double size) {
  std::uniform_real_distribution<double> uniform(-size, size);
  Matrix<dim> H;
  for (int i = 0; i < dim; ++i)
    for (int j = 0; j < dim; ++j) H(i, j) = uniform(random);
  return H;
}

/// Uniaxial stress at an axial logarithmic strain: the strain across makes the stress across zero.
Matrix<3> uniaxial(const Point<3>& point, double strain) {
  double across = -nu * strain;
  const auto gradient = [&](double t) {
    return Matrix<3>(Vector<3>(std::expm1(strain), std::expm1(t), std::expm1(t)).asDiagonal());
  };
  for (int k = 0; k < 50; ++k) {
    const double h = 1e-7;
    const double stress = point.at(gradient(across)).tau[1];
    const double slope = (point.at(gradient(across + h)).tau[1] - stress) / h;
    across -= stress / slope;
  }
  return gradient(across);
}

/// Isotropic and kinematic hardening over a cycle of half a per cent; the numbers are those of the
/// law in one dimension, whose stress over logarithmic strain this is.
TEST(VonMises, cyclic_bar) {
  Point<3> point{steel<3>(1e9, 5e9)};
  const std::vector<std::pair<double, double>> cycle = {
      {0.005, 271.845e6}, {-0.005, -278.914e6}, {0.005, 285.915e6}};
  for (const auto& [strain, stress] : cycle) {
    const Matrix<3> H = uniaxial(point, strain);
    EXPECT_NEAR(point.at(H).tau[0], stress, 600);  // of the six digits
    point.accept(H);
  }
  EXPECT_NEAR(point.history.back(), 0.0180628, 6e-8);
}

template <int dim>
void expect_elastic_law() {
  std::mt19937 random(5);
  const HenckyElastic<dim> elastic{lambda, mu};
  Point<dim> point{steel<dim>(0, 0)};
  point.law.hardening = Hardening::linear(1e30, 0);
  for (const double size : {0.0, 1e-9, 1e-4, 0.05, 0.4}) {
    const Matrix<dim> H = random_gradient<dim>(random, size);
    Tangent<dim> A, exact_A;
    const auto found = point.at(H, &A);
    StressUpdate<dim> exact;
    ASSERT_TRUE(elastic.update(H, {}, exact, &exact_A));
    EXPECT_LT((found.P - exact.P).norm(), 1e-12 * E * size + 1e-300);
    EXPECT_LT((found.tau - exact.tau).norm(), 1e-12 * E * size + 1e-300);
    EXPECT_NEAR(found.energy, exact.energy, 1e-12 * E * size * size + 1e-300);
    EXPECT_LT((A - exact_A).norm(), 1e-12 * E);
  }
}

TEST(VonMises, is_hencky_elasticity_below_the_yield_stress) {
  expect_elastic_law<2>();
  expect_elastic_law<3>();
}

template <int dim>
void expect_tangent(const VonMises<dim>& law, double size) {
  std::mt19937 random(11);
  Point<dim> point{law};
  point.accept(random_gradient<dim>(random, 0.05));  // axes other than those to come
  const Matrix<dim> H_0 = random_gradient<dim>(random, size);
  Tangent<dim> A;
  point.at(H_0, &A);
  std::vector<double> history(point.history);
  StressUpdate<dim> out;
  ASSERT_TRUE(law.update(H_0, point.history, history, out, nullptr));
  EXPECT_GT(history.back(), point.history.back());  // it flows
  const auto stress = [&](const Eigen::VectorXd& x) {
    Matrix<dim> H;
    for (int k = 0; k < dim * dim; ++k) H(k / dim, k % dim) = x[k];
    const Matrix<dim> P = point.at(H).P;
    Eigen::VectorXd values(dim * dim);
    for (int k = 0; k < dim * dim; ++k) values[k] = P(k / dim, k % dim);
    return values;
  };
  Eigen::VectorXd x(dim * dim);
  for (int k = 0; k < dim * dim; ++k) x[k] = H_0(k / dim, k % dim);
  EXPECT_LT(tangent_error(stress, x, A, 1e-4), 1e-7);
  EXPECT_LT((A - A.transpose()).norm(), 1e-12 * E);
}

TEST(VonMises, tangent_against_differences) {
  for (const double size : {1e-9, 0.03, 0.4}) {
    for (const double hardening : {0.0, 2e9}) {
      expect_tangent<2>(steel<2>(hardening, 2 * hardening), size);
      expect_tangent<3>(steel<3>(hardening, 2 * hardening), size);
    }
  }
}

/// At equal stretches the axes of C are not told apart.
TEST(VonMises, tangent_at_equal_stretches) {
  Point<3> point{steel<3>(1e9, 1e9)};
  std::mt19937 random(2);
  point.accept(random_gradient<3>(random, 0.05));
  const auto stress = [&](const Eigen::VectorXd& x) {
    const Matrix<3> P = point.at(Eigen::Map<const Matrix<3>>(x.data()).transpose()).P.transpose();
    return Eigen::VectorXd(Eigen::Map<const Eigen::VectorXd>(P.data(), 9));
  };
  for (const double stretch : {0.0, 0.1}) {
    const Matrix<3> H = stretch * Matrix<3>::Identity();
    Tangent<3> A;
    point.at(H, &A);
    const Eigen::VectorXd x = Eigen::Map<const Eigen::VectorXd>(H.data(), 9);
    EXPECT_LT(tangent_error(stress, x, A, 1e-4), 1e-7);
  }
}

/// A turn by 90 degrees turns P and leaves the history.
TEST(VonMises, a_rotation_adds_nothing) {
  std::mt19937 random(3);
  Point<3> still{steel<3>(1e9, 5e9)}, turned = still;
  const Matrix<3> H = random_gradient<3>(random, 0.02);
  const Matrix<3> Q =
      Eigen::AngleAxisd(M_PI / 2, Vector<3>(1, 2, -1).normalized()).toRotationMatrix();
  const Matrix<3> QH = Q * (Matrix<3>::Identity() + H) - Matrix<3>::Identity();
  EXPECT_LT((turned.at(QH).P - Q * still.at(H).P).norm(), 1e-14 * E);
  still.accept(H);
  turned.accept(QH);
  for (std::size_t k = 0; k < still.history.size(); ++k) {
    EXPECT_NEAR(turned.history[k], still.history[k], 1e-15);
  }
  EXPECT_GT(still.history.back(), 1e-3);
}

/// A state that was returned and is not strained again keeps its history to the bit.
TEST(VonMises, a_repeated_state_stays) {
  std::mt19937 random(9);
  for (const double size : {2e-3, 0.05, 0.5}) {
    Point<2> point{steel<2>(0, 0)};
    const Matrix<2> H = random_gradient<2>(random, size);
    point.accept(H);
    const auto history = point.history;
    point.accept(H);
    EXPECT_EQ(point.history, history) << size;
  }
}

TEST(VonMises, folded_states_are_inadmissible) {
  const auto law = steel<2>(0, 0);
  std::vector<double> history(VonMises<2>::history_size, 0.0), next(history);
  StressUpdate<2> out;
  EXPECT_FALSE(law.update(Matrix<2>{{-2, 0}, {0, 0}}, history, next, out, nullptr));
  EXPECT_FALSE(law.update(Matrix<2>{{-1, 0}, {0, 0}}, history, next, out, nullptr));
}

TEST(Hardening, rows_of_a_table) {
  const auto table = Hardening::table({0, 0.01, 0.1}, {200, 200, 290});
  EXPECT_EQ(table.yield_stress(0.005), 200);
  EXPECT_NEAR(table.yield_stress(0.06), 250, 1e-12);
  EXPECT_EQ(table.yield_stress(0.5), 290);
  EXPECT_NEAR(table.work(0.2), 2 + 245 * 0.09 + 29, 1e-12);
  for (const double p : {0.0, 0.005, 0.05, 0.3}) {
    for (const double excess : {1e-3, 1.0, 50.0, 5e3}) {
      const double stiffness = 1e4, q = table.yield_stress(p) + excess;
      const double dp = table.flow(q, p, stiffness).strain;
      EXPECT_GT(dp, 0);
      EXPECT_NEAR(q - stiffness * dp - table.yield_stress(p + dp), 0, 1e-10);
    }
  }
  EXPECT_EQ(table.flow(200 + 1e4 * 0.001, 0, 1e4).slope, 0);
  EXPECT_NEAR(table.flow(200 + 1e4 * 0.05, 0, 1e4).slope, 1000, 1e-9);
}

/// Plastic work is the work of the stresses beyond the elastic energy, in small steps along any
/// path.
TEST(VonMises, plastic_work_of_a_way) {
  std::mt19937 random(4);
  Point<2> point{steel<2>(1e9, 5e9)};
  const Matrix<2> first = random_gradient<2>(random, 0.01),
                  second = random_gradient<2>(random, 0.01);
  Matrix<2> H = Matrix<2>::Zero(), P = Matrix<2>::Zero();
  double work = 0;
  const auto go = [&](const Matrix<2>& end) {
    constexpr int steps = 2000;
    const Matrix<2> step = (end - H) / steps;
    for (int n = 0; n < steps; ++n) {
      H += step;
      const Matrix<2> next = point.at(H).P;
      work += 0.5 * (P + next).cwiseProduct(step).sum();
      P = next;
      point.accept(H);
    }
  };
  go(first);
  go(second);
  const double kept = point.at(H).energy + point.law.plastic_work(point.history);
  EXPECT_NEAR(work, kept, 1e-4 * kept);
}

TEST(LogStrain, curvature_of_the_logarithm) {
  EXPECT_NEAR(fem::log_curvature(2, 2, 2), -1.0 / 16, 1e-16);
  for (const double spread : {1e-6, 0.0999, 0.1001}) {  // both sides of the switch
    const double x = 1 - spread, y = 1 + 0.3 * spread, z = 1 + 0.7 * spread;
    const auto first = [](double a, double b) { return 0.5 * std::log(b / a) / (b - a); };
    const double exact = (first(y, z) - first(x, y)) / (z - x);
    EXPECT_NEAR(fem::log_curvature(x, y, z), exact, spread < 1e-3 ? 1e-4 : 1e-14);
    EXPECT_EQ(fem::log_curvature(x, y, z), fem::log_curvature(z, x, y));
  }
}

/// Elastic laws in terms of the logarithmic strain are those in terms of H.
template <class Law, int dim>
void expect_log_stress(const Law& law) {
  std::mt19937 random(6);
  for (const double size : {1e-7, 0.1, 0.4}) {
    const Matrix<dim> H = random_gradient<dim>(random, size);
    const Matrix<dim> F = Matrix<dim>::Identity() + H;
    StressUpdate<dim> exact;
    Tangent<dim> A, exact_A;
    ASSERT_TRUE(law.update(H, {}, exact, &exact_A));
    fem::LogStrain<dim> strain;
    ASSERT_TRUE(fem::find_log_strain<dim>(fem::twice_green_strain<dim>(H), strain));
    fem::LogStress<dim> stress;
    fem::log_stress<dim>(law, strain.E, stress);
    const auto green =
        fem::turned_to_green<dim>(strain, fem::log_by_green<dim>(strain), stress, true);
    EXPECT_LT((F * fem::strain_tensor<dim>(green.S) - exact.P).norm(), 1e-12 * E * size);
    // Strains are of size `size` and carry round-off of 1 + H, 2 eps: so does the energy, by E size.
    EXPECT_NEAR(stress.energy, exact.energy, (1e-9 * size + 4e-16) * E * size);
    fem::first_tangent<dim>(F, green, A);
    EXPECT_LT((A - exact_A).norm(), 1e-12 * exact_A.norm());
  }
}

TEST(LogStrain, elastic_laws) {
  expect_log_stress<NeoHookean<2>, 2>({lambda, mu});
  expect_log_stress<NeoHookean<3>, 3>({lambda, mu});
  expect_log_stress<HenckyElastic<2>, 2>({lambda, mu});
  expect_log_stress<HenckyElastic<3>, 3>({lambda, mu});
}

}  // namespace
}  // namespace gabion::test::test_von_mises
