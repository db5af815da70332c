// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "tests/verification/mpm/manufactured_orders.hpp"

namespace gabion::test {
namespace {

/// Fourth-order central difference of f at 0 with step h.
template <class Function>
auto difference(const Function& f, double h) {
  return ((8 * (f(h) - f(-h)) - (f(2 * h) - f(-2 * h))) / (12 * h)).eval();
}

/// u_tt - Div P / rho by differences of u alone, with the stress of elastic_laws.hpp.
template <int dim>
Vector<dim> differenced_source(const Manufactured<dim>& exact, const Vector<dim>& X, double t) {
  const Lame lame(exact.E, exact.nu);
  constexpr double h = 1e-3;
  const auto piola = [&](const Vector<dim>& at) -> Matrix<dim> {
    Matrix<dim> F = Matrix<dim>::Identity();
    for (int J = 0; J < dim; ++J) {
      F.col(J) += difference(
          [&](double s) -> Vector<dim> { return exact.u(at + s * Vector<dim>::Unit(J), t); }, h);
    }
    const Matrix<3> tau = exact_stress<dim>("neo_hookean", lame, F);
    return tau.topLeftCorner<dim, dim>() * F.inverse().transpose();
  };
  const double dt = 1e-3 * exact.end;
  const auto v = [&](double s) -> Vector<dim> {
    return difference([&](double r) -> Vector<dim> { return exact.u(X, t + s + r); }, dt);
  };
  Vector<dim> b = difference(v, dt);
  for (int J = 0; J < dim; ++J) {
    b -= difference([&](double s) -> Matrix<dim> { return piola(X + s * Vector<dim>::Unit(J)); }, h)
             .col(J) /
         exact.density;
  }
  return b;
}

/// The body accelerations fit the motions: nothing here is taken from the literature unchecked.
template <int dim>
void check_source(const std::string& id, const std::string& what, const Manufactured<dim>& exact,
                  const Vector<dim>& X) {
  double error = 0, size = 0;
  for (const double share : {0.15, 0.4, 0.7}) {
    const double t = share * exact.end;
    const Vector<dim> b = exact.b(X, t);
    error = std::max(error, (b - differenced_source<dim>(exact, X, t)).norm());
    size = std::max(size, b.norm());
  }
  verify({.id = id,
          .what = "body acceleration of the " + what + " against differences of its motion",
          .exact = 0,
          .computed = error / size,
          .measure = Measure::absolute_error,
          .bound = 1e-7});
}

TEST(V5_StandingWave, source) {
  check_source<2>("V5", "standing wave", standing_wave<2>(0.05), {0.13, 0.4});
}
TEST(V3_AxisAlignedWaves, source) {
  check_source<2>("V3", "axis-aligned waves", axis_aligned_waves<2>(0.05), {0.13, 0.4});
  check_source<3>("V3", "axis-aligned waves, 3D", axis_aligned_waves<3>(0.05), {0.13, 0.4, 0.2});
}
TEST(V4_Vortex, source) {
  check_source<2>("V4", "vortex", vortex<2>(1), {0.9, 0.3});
}

template <int dim>
ManufacturedBox strip(int n) {
  ManufacturedBox shape{.low = std::vector<double>(dim, 0.0),
                        .high = std::vector<double>(dim, 1.0 / n),
                        .cells = std::vector<int>(dim, 1),
                        .type = dim == 2 ? "quad4" : "hex8",
                        .points_per_cell = dim == 2 ? 4 : 8};
  shape.high[0] = 1;
  shape.cells[0] = n;
  return shape;
}

TEST(V5_StandingWave, small_2d) {
  for (const Expected& expected : {Expected{"linear", 1e-3, 1.9}, Expected{"gimp", 1e-3, 1.9},
                                   Expected{"bspline", 4e-3, 1.9}}) {
    const OrderStudy<2> study{"V5", "A = 1e-4", standing_wave<2>(1e-4), strip<2>, expected.basis};
    order_in_h(study, {16, 32, 64}, 200, expected);
    order_in_dt(study, 64, {10, 20, 40}, 1.9);
  }
}

TEST(V5_StandingWave, small_3d) {
  const OrderStudy<3> study{"V5", "A = 1e-4, 3D", standing_wave<3>(1e-4), strip<3>};
  order_in_h(study, {8, 16, 32}, 50, {"linear", 4e-3, 1.9});
}

TEST(V5_StandingWave, large) {
  for (const Expected& expected :
       {Expected{"linear", 0.6, {}, cells_are_crossed}, Expected{"gimp", 2.7e-3, 1.9},
        Expected{"bspline", 0.028, {}, points_are_uneven}}) {
    const OrderStudy<2> study{"V5", "A = 0.05", standing_wave<2>(0.05), strip<2>, expected.basis};
    order_in_h(study, {8, 16, 32, 64}, 200, expected);
  }
}

ManufacturedBox square(int n) {
  return {{0, 0}, {1, 1}, {n, n}, "quad4"};
}

TEST(V3_AxisAlignedWaves, small) {
  const OrderStudy<2> study{"V3", "A = 1e-4", axis_aligned_waves<2>(1e-4), square};
  order_in_h(study, {8, 16, 32}, 40, {"linear", 4e-3, 1.9});
}

}  // namespace
}  // namespace gabion::test
