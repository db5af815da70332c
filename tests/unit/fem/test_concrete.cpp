// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <random>
#include <vector>

#include "common/mechanics/materials/elastic.hpp"
#include "fem_solver/materials/concrete.hpp"
#include "tests/support/check_tangent.hpp"
#include "tests/support/mpi_main.hpp"

namespace gabion::test::test_concrete {
namespace {

using fem::Concrete;
using fem::CrackBand;

constexpr double E = 30e9, f_t = 3e6, f_c = 38e6, fracture_energy = 100, crushing_energy = 54e3;
constexpr double width = 0.05;

/// Concrete of cells that are squares or cubes.
template <int dim>
struct Point {
  Concrete<dim> law;
  CrackBand<dim> band{.edges = width * Matrix<dim>::Identity(), .mean = width};
  std::vector<double> history = std::vector<double>(Concrete<dim>::history_size, 0.0);

  explicit Point(double nu = 0.2) {
    law.lambda = E * nu / ((1 + nu) * (1 - 2 * nu));
    law.mu = E / (2 * (1 + nu));
    law.tension = {
        .modulus = law.lambda + 2 * law.mu, .strength = f_t, .fracture_energy = fracture_energy};
    law.crushing = {.modulus = E,
                    .elastic_limit = 0.4 * f_c,
                    .strength = f_c,
                    .strain_at_strength = 2.2e-3,
                    .crushing_energy = crushing_energy};
  }
  fem::ConcreteOfCell<dim> here() const { return {law, band}; }
  StressUpdate<dim> at(const Matrix<dim>& H, Tangent<dim>* A = nullptr) const {
    std::vector<double> unused(history);
    StressUpdate<dim> out;
    EXPECT_TRUE(here().update(H, history, unused, out, A));
    return out;
  }
  void accept(const Matrix<dim>& H) {
    std::vector<double> next(history);
    StressUpdate<dim> out;
    ASSERT_TRUE(here().update(H, history, next, out, nullptr));
    history = next;
  }
  /// T at principal logarithmic strains, which become the accepted state.
  Symmetric<dim> stretch(const Vector<3>& strains) {
    Symmetric<dim> strain = Symmetric<dim>::Zero();
    strain.template head<3>() = strains;
    fem::LogStress<dim> stress;
    std::vector<double> next(history);
    here().log_stress(strain, history, next, stress);
    history = next;
    return stress.T;
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

/// Cracked, closed, crushed and opened again: the stress of a bar follows the two curves, and goes
/// to the origin in tension and along E where the crack closes.
TEST(Concrete, uniaxial_cycle) {
  Point<3> point(0);
  const auto stress = [&](double strain) { return point.stretch({strain, 0, 0})[0]; };
  const double H = width / (2 * E * fracture_energy / (f_t * f_t) - width);
  const auto softened = [&](double strain) {
    return f_t * std::exp(2 * H * (1 - E * strain / f_t));
  };
  EXPECT_NEAR(stress(0.9e-4), 2.7e6, 1e-6);
  EXPECT_NEAR(stress(1e-4), f_t, 1e-6);
  for (const double strain : {1.5e-4, 4e-4}) EXPECT_NEAR(stress(strain), softened(strain), 1e-6);
  EXPECT_NEAR(stress(2e-4), 0.5 * softened(4e-4), 1e-6);  // to the origin
  const double opening = width * (2e-4 - 0.5 * softened(4e-4) / E);
  EXPECT_NEAR(point.history[4], opening, 1e-15);
  EXPECT_NEAR(stress(-3e-4), -9e6, 1e-6);  // closed, below the elastic limit
  EXPECT_EQ(point.history[4], 0);
  EXPECT_NEAR(stress(-2.2e-3), -f_c, 1e-6);
  const double decay = crushing_energy / (width * f_c);
  EXPECT_NEAR(stress(-2.2e-3 - 2 * decay), -f_c * std::exp(-2.0), 1e-5);
  EXPECT_NEAR(stress(-1e-3), -f_c * std::exp(-2.0) * 1e-3 / (2.2e-3 + 2 * decay), 1e-5);
  EXPECT_NEAR(stress(4e-4), softened(4e-4), 1e-6);  // as cracked as before
}

/// A bar that is torn, then crushed, took both energies per area of its band and what the rise to
/// the strength takes.
TEST(Concrete, takes_its_energies) {
  Point<3> point(0);
  for (int n = 1; n <= 200; ++n) point.stretch({2e-6 * n * n / 2, 0, 0});
  EXPECT_NEAR(point.history[5] * width, fracture_energy, 1e-6 * fracture_energy);
  const double torn = point.history[5];
  for (int n = 1; n <= 300; ++n) point.stretch({-0.5 * n / 300, 0, 0});
  const double rise = f_c - 0.4 * f_c, run = 2.2e-3 - 0.4 * f_c / E;
  const double before = 0.5 * 0.16 * f_c * f_c / E + (f_c - rise / 3) * run;
  EXPECT_NEAR((point.history[5] - torn) * width, crushing_energy + before * width,
              1e-4 * crushing_energy);
}

/// One step or a thousand: the damage of a state on a straight path, and the energy that it took.
TEST(Concrete, is_independent_of_the_steps) {
  Point<3> one, many;
  const Vector<3> end(8e-4, 1e-4, -6e-4);
  one.stretch(end);
  for (int n = 1; n <= 1000; ++n) many.stretch(end * n / 1000.0);
  for (int k = 0; k < Concrete<3>::history_size; ++k) {
    EXPECT_NEAR(one.history[k], many.history[k], 1e-9 * std::abs(many.history[k])) << k;
  }
}

/// Largest stress on a path along which both stresses in a plane are in a ratio, with no stress
/// across the plane.
double biaxial_strength(double ratio, double sign) {
  Point<3> point;
  const double nu = 0.2;
  double largest = 0;
  for (int n = 1; n <= 4000; ++n) {  // of the elastic stress; secant damage keeps the ratios
    const double s_1 = sign * n * 25e3, s_2 = ratio * s_1;
    const Vector<3> strain = Vector<3>(s_1 - nu * s_2, s_2 - nu * s_1, -nu * (s_1 + s_2)) / E;
    largest = std::max(largest, std::abs(point.stretch(strain)[0]));
  }
  return largest;
}

TEST(Concrete, biaxial_strengths) {
  EXPECT_NEAR(biaxial_strength(0, -1), f_c, 1e-4 * f_c);
  EXPECT_NEAR(biaxial_strength(1, -1), 1.16 * f_c, 1e-4 * f_c);
  EXPECT_NEAR(biaxial_strength(0, 1), f_t, 0.01 * f_t);
  EXPECT_NEAR(biaxial_strength(1, 1), f_t, 0.01 * f_t);
  const double alpha = 0.16 / 1.32, shear = f_t / f_c / (1 - alpha) * (std::sqrt(3) - 1 - alpha);
  EXPECT_NEAR(biaxial_strength(-1, 1), f_t / (1 + shear), 0.01 * f_t);
}

template <int dim>
void expect_tangent(double size, unsigned seed, bool with_history) {
  std::mt19937 random(seed);
  Point<dim> point;
  if (with_history) point.accept(random_gradient<dim>(random, 0.6 * size));
  const Matrix<dim> H_0 = random_gradient<dim>(random, size);
  Tangent<dim> A;
  point.at(H_0, &A);
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
  EXPECT_LT(tangent_error(stress, x, A, 1e-4 * size), 1e-7) << dim << " " << size << " " << seed;
}

TEST(Concrete, tangent_against_differences) {
  for (const double size : {3e-5, 2e-4, 2e-3, 0.02}) {
    for (const unsigned seed : {1, 2, 3, 4, 5, 6}) {
      for (const bool with_history : {false, true}) {
        expect_tangent<2>(size, seed, with_history);
        expect_tangent<3>(size, seed, with_history);
      }
    }
  }
}

template <int dim>
void expect_elastic_law() {
  std::mt19937 random(5);
  const Point<dim> point;
  const HenckyElastic<dim> elastic{point.law.lambda, point.law.mu};
  const Matrix<dim> H = random_gradient<dim>(random, 2e-5);
  Tangent<dim> A, exact_A;
  StressUpdate<dim> exact;
  ASSERT_TRUE(elastic.update(H, {}, exact, &exact_A));
  const StressUpdate<dim> found = point.at(H, &A);
  EXPECT_LT((found.P - exact.P).norm(), 1e-12 * exact.P.norm());
  EXPECT_LT((A - exact_A).norm(), 1e-12 * exact_A.norm());
  EXPECT_NEAR(found.energy, exact.energy, 1e-9 * exact.energy);
}

TEST(Concrete, is_hencky_elasticity_below_its_strengths) {
  expect_elastic_law<2>();
  expect_elastic_law<3>();
}

/// A turn by 90 degrees turns P and leaves the history, also of a cracked point.
TEST(Concrete, a_rotation_adds_nothing) {
  std::mt19937 random(3);
  Point<3> still;
  still.accept(random_gradient<3>(random, 1e-3));
  EXPECT_GT(still.law.tensile_damage(still.history), 0.1);
  Point<3> turned = still;
  const Matrix<3> H = random_gradient<3>(random, 3e-3);
  const Matrix<3> Q =
      Eigen::AngleAxisd(M_PI / 2, Vector<3>(1, 2, -1).normalized()).toRotationMatrix();
  const Matrix<3> QH = Q * (Matrix<3>::Identity() + H) - Matrix<3>::Identity();
  EXPECT_LT((turned.at(QH).P - Q * still.at(H).P).norm(), 1e-14 * E);
  still.accept(H);
  turned.accept(QH);
  for (int k = 0; k < Concrete<3>::history_size; ++k) {
    EXPECT_NEAR(turned.history[k], still.history[k], 1e-9 * std::abs(still.history[k])) << k;
  }
}

/// A crack takes its energy and follows its curve whether it may contract along itself or not: with
/// the opening strain a, M = lambda + 2 mu and the stress T across it, a bar that is free at its
/// sides is longer by 2 nu^2 / (1 - nu) T / E and thinner by nu T / E.
TEST(Concrete, crack_of_a_bar_and_of_a_layer) {
  for (const double nu : {0.0, 0.1, 0.2, 0.3}) {
    Point<3> bar(nu), layer(nu);
    const double M = bar.law.p_wave_modulus();
    const double H = width / (2 * M * fracture_energy / (f_t * f_t) - width);
    double work = 0, before = 0, length = 0;
    constexpr int steps = 4000;
    for (int n = 1; n <= steps; ++n) {
      const double a = 0.02 * n * n / (steps * steps);
      const double T = M * a < f_t ? M * a : f_t * std::exp(2 * H * (1 - M * a / f_t));
      const double left = std::max(T, 1e-6 * M * a);
      const double e = a + 2 * nu * nu / (1 - nu) * left / E, side = -nu * left / E;
      const Symmetric<3> free = bar.stretch({e, side, side}), held = layer.stretch({a, 0, 0});
      EXPECT_NEAR(free[0], left, 1e-9 * f_t) << nu << " " << n;
      EXPECT_NEAR(free[1], 0, 1e-9 * f_t) << nu << " " << n;
      EXPECT_NEAR(held[0], left, 1e-9 * f_t) << nu << " " << n;
      work += 0.5 * (before + free[0]) * (e - length);
      before = free[0];
      length = e;
    }
    const double rest = 0.5 * 1e-6 * M * 0.02 * 0.02;  // of the stiffness that is left
    EXPECT_NEAR(bar.history[5] * width, fracture_energy, 1e-3 * fracture_energy) << nu;
    EXPECT_NEAR(layer.history[5] * width, fracture_energy, 1e-3 * fracture_energy) << nu;
    EXPECT_NEAR((work - rest) * width, fracture_energy, 1e-3 * fracture_energy) << nu;
    EXPECT_NEAR(bar.history[4], width * 0.02, 1e-5 * width * 0.02) << nu;
  }
}

/// Torn concrete has the full stiffness in compression, with its lateral strain, and is not crushed
/// by a crack that stands open across a strut.
TEST(Concrete, closed_cracks_and_struts_are_stiff) {
  for (const double nu : {0.0, 0.2}) {
    Point<3> point(nu);
    point.stretch({0.02, 0, 0});
    const Symmetric<3> closed = point.stretch({-3e-4, nu * 3e-4, nu * 3e-4});
    EXPECT_NEAR(closed[0], -E * 3e-4, 1e-9 * E * 3e-4);
    EXPECT_NEAR(closed[1], 0, 1e-9 * E * 3e-4);
    EXPECT_NEAR(closed[2], 0, 1e-9 * E * 3e-4);
    const Symmetric<3> strut = point.stretch({0.02 + nu * 3e-4, -3e-4, nu * 3e-4});
    EXPECT_NEAR(strut[1], -E * 3e-4, 1e-5 * E);  // a millionth of the crack's stiffness is left
    EXPECT_EQ(point.law.compressive_damage(point.history), 0);
  }
}

/// A point that was strained at random and far, so that it cracked, and most points were crushed.
template <int dim>
Point<dim> damaged_point(std::mt19937& random, double nu) {
  Point<dim> point(nu);
  for (int n = 0; n < 4; ++n) point.accept(random_gradient<dim>(random, 3e-3));
  return point;
}

/// The stress at constant damage is the slope of the energy, so that no cycle of strains makes any,
/// whether or not axes turn or strains change their sign.
template <int dim>
void expect_potential(double nu) {
  std::mt19937 random(7);
  int crushed = 0;
  for (int k = 0; k < 50; ++k) {
    const Point<dim> point = damaged_point<dim>(random, nu);
    EXPECT_GT(point.law.tensile_damage(point.history), 0.5);
    if (point.law.compressive_damage(point.history) > 0) ++crushed;
    const Matrix<dim> H = random_gradient<dim>(random, 2e-4);
    const Matrix<dim> along = random_gradient<dim>(random, 1);
    const double step = 1e-7;
    const double more = point.at(H + step * along).energy, less = point.at(H - step * along).energy;
    Tangent<dim> A;
    const StressUpdate<dim> found = point.at(H, &A);
    const double slope = found.P.cwiseProduct(along).sum();
    EXPECT_NEAR((more - less) / (2 * step), slope, 1e-5 * found.P.norm()) << dim << " " << k;
    EXPECT_LT((A - A.transpose()).norm(), 1e-12 * A.norm()) << dim << " " << k;
  }
  EXPECT_GT(crushed, 25) << dim << " " << nu;
}

TEST(Concrete, has_an_energy_at_constant_damage) {
  for (const double nu : {0.0, 0.2, 0.4, -0.2}) {
    expect_potential<2>(nu);
    expect_potential<3>(nu);
  }
}

/// Work around a closed path of strains at constant damage, each of whose sides the stress changes
/// linearly on: across and along an open crack in turn.
TEST(Concrete, work_around_a_loop_at_constant_damage) {
  for (const double nu : {0.0, 0.1, 0.2}) {
    Point<2> point(nu);
    point.stretch({6e-4, 0, 0});
    const double d = point.law.tensile_damage(point.history);
    EXPECT_GT(d, 0.5);
    const double low = 1e-4, high = 2e-4, left = -1.6e-4, right = -0.6e-4;
    const std::vector<Vector<3>> corners = {
        {low, left, 0}, {high, left, 0}, {high, right, 0}, {low, right, 0}, {low, left, 0}};
    double work = 0;
    for (std::size_t k = 1; k < corners.size(); ++k) {
      const Symmetric<2> before = point.stretch(corners[k - 1]), after = point.stretch(corners[k]);
      work += 0.5 * (before + after).head<3>().dot(corners[k] - corners[k - 1]);
    }
    EXPECT_EQ(point.law.tensile_damage(point.history), d);
    EXPECT_EQ(point.law.compressive_damage(point.history), 0);
    EXPECT_NEAR(work, 0, 1e-15 * E * 1e-8) << nu;
  }
}

/// On any path the work is what is stored and what damage took, and damage never gives any back.
TEST(Concrete, damage_only_takes) {
  for (const double nu : {0.0, 0.2}) {
    std::mt19937 random(11);
    Point<3> point(nu);
    Matrix<3> H = Matrix<3>::Zero();
    double work = 0, stored = 0, largest = 0;
    for (int side = 0; side < 30; ++side) {
      const Matrix<3> end = random_gradient<3>(random, 2e-3), from = H;
      constexpr int parts = 2000;
      Matrix<3> P = point.at(H).P;
      for (int n = 1; n <= parts; ++n) {
        const double taken = point.history[5];
        const Matrix<3> next = from + (end - from) * n / parts;
        const StressUpdate<3> now = point.at(next);
        point.accept(next);
        work += 0.5 * (P + now.P).cwiseProduct(next - H).sum();
        EXPECT_GE(point.history[5], taken);
        H = next;
        P = now.P;
        stored = now.energy;
      }
      largest = std::max(largest, work);
      EXPECT_NEAR(work, stored + point.history[5], 1e-3 * largest) << nu << " " << side;
    }
  }
}

/// A crack takes the edge that it opens along, whatever the sign of its normal.
TEST(CrackBand, follows_the_normal) {
  const CrackBand<2> band{.edges = Matrix<2>{{0.2, 0}, {0, 0.05}}, .mean = 0.1};
  EXPECT_DOUBLE_EQ(band.width({1, 0}), 0.2);
  EXPECT_DOUBLE_EQ(band.width({-0.8, 0.6}), 0.2);
  EXPECT_DOUBLE_EQ(band.width({0.6, 0.8}), 0.05);  // though the long edge reaches farther along it
  EXPECT_DOUBLE_EQ(band.width({0, -1}), 0.05);
  EXPECT_DOUBLE_EQ(band.width({0, 0}), 0.1);  // normal to the plane
  EXPECT_DOUBLE_EQ(band.largest(), 0.2);
}

TEST(Concrete, folded_states_are_inadmissible) {
  const Point<2> point;
  std::vector<double> next(point.history);
  StressUpdate<2> out;
  EXPECT_FALSE(point.here().update(Matrix<2>{{-2, 0}, {0, 0}}, point.history, next, out, nullptr));
}

}  // namespace
}  // namespace gabion::test::test_concrete
