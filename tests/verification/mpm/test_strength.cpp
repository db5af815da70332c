// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/verification_row.hpp"
#include "tests/verification/elastic_laws.hpp"
#include "tests/verification/mpm/driven_block.hpp"

namespace gabion::test {
namespace {

/// The soil is so stiff that nominal and true stresses differ by less than 1e-6: strains are
/// pressure / E.
constexpr double E = 1e11, nu = 0.3, pressure = 1e3;
constexpr double degree = M_PI / 180;
const Lame lame(E, nu);

struct Angles {
  double phi, psi;  // [deg]
};
const std::vector<Angles> all_angles = {{19.8, 0}, {30, 0}, {30, 10}, {30, 30}};

/// One cell of Mohr-Coulomb soil under an all-round pressure, in plane strain.
template <int dim>
struct SoilElement : DrivenBlock<dim> {
  explicit SoilElement(const Angles& angles)
      : DrivenBlock<dim>(
            dim == 2 ? CellType::quad4 : CellType::hex8, 1,
            MohrCoulomb<dim>(lame.lambda, lame.mu, angles.phi * degree, angles.psi * degree, 0),
            Vector<dim>::Zero(), Vector<dim>::Ones(), 1, dim == 2 ? 4 : 8) {
    const double e = std::expm1(-2 * pressure / (3 * lame.lambda + 2 * lame.mu));
    for (auto& history : this->soil.points.history) {
      history.e.template head<3>().setConstant(e);
    }
  }
};

/// Force in direction d on the face x_axis = 1, that is the nominal stress there [Pa].
template <int dim>
double force_on_face(const DrivenBlock<dim>& block, int axis, int d) {
  double sum = 0;
  for (std::int32_t i = 0; i < block.soil.nodes.size(); ++i) {
    if (block.soil.node(i)[axis] > 0.5) sum += block.f_int[i * dim + d];
  }
  return sum;
}

/// One step of H whose component H(axis, axis) is chosen so that the normal force on that face
/// stays -pressure (secant method).
template <int dim>
void move_under_pressure(DrivenBlock<dim>& block, Matrix<dim> H, int axis) {
  const auto residual = [&](double h) {
    H(axis, axis) = h;
    block.try_move(H, Vector<dim>::Zero());
    return force_on_face(block, axis, axis) + pressure;
  };
  double h0 = 0, r0 = residual(h0), h1 = -r0 / (lame.lambda + 2 * lame.mu), r1 = residual(h1);
  for (int k = 0; k < 50 && std::abs(r1) > 1e-9 * pressure; ++k) {
    const double h = h1 - r1 * (h1 - h0) / (r1 - r0);
    h0 = h1;
    r0 = r1;
    h1 = h;
    r1 = residual(h1);
  }
  ASSERT_LE(std::abs(r1), 1e-9 * pressure);
  block.move(H, Vector<dim>::Zero());
}

std::string described(const Angles& angles, int dim) {
  return fmt::format(", phi = {}, psi = {}, one cell, MPM {}", angles.phi, angles.psi,
                     dim == 2 ? "quad4" : "hex8");
}

/// Simple shear without strain along the plane and under a normal pressure: tau / sigma_n = sin phi
/// cos psi / (1 - sin phi sin psi), Davis (1968).
template <int dim>
void check_simple_shear() {
  for (const Angles& angles : all_angles) {
    SoilElement<dim> block(angles);
    Matrix<dim> H = Matrix<dim>::Zero();
    H(0, 1) = 0.2 * pressure / lame.mu;
    for (int step = 0; step < 100; ++step) move_under_pressure(block, H, 1);
    const double sin_phi = std::sin(angles.phi * degree), psi = angles.psi * degree;
    verify({.id = "V14",
            .what = "simple shear, tau / sigma_n" + described(angles, dim),
            .exact = sin_phi * std::cos(psi) / (1 - sin_phi * std::sin(psi)),
            .computed = force_on_face(block, 1, 0) / pressure,
            .bound = 1e-5});
  }
}
TEST(V14_Strength, simple_shear_2d) {
  check_simple_shear<2>();
}
TEST(V14_Strength, simple_shear_3d) {
  check_simple_shear<3>();
}

/// Squeezed along y in plane strain under a pressure along x: sigma_1 / sigma_3 = (1 + sin phi) /
/// (1
/// - sin phi), whatever psi.
template <int dim>
void check_biaxial() {
  for (const Angles& angles : all_angles) {
    SoilElement<dim> block(angles);
    Matrix<dim> H = Matrix<dim>::Zero();
    H(1, 1) = -0.1 * pressure / lame.mu;
    for (int step = 0; step < 100; ++step) move_under_pressure(block, H, 0);
    const double sin_phi = std::sin(angles.phi * degree);
    verify({.id = "V14",
            .what = "biaxial test, sigma_1 / sigma_3" + described(angles, dim),
            .exact = (1 + sin_phi) / (1 - sin_phi),
            .computed = -force_on_face(block, 1, 1) / pressure,
            .bound = 1e-5});
  }
}
TEST(V14_Strength, biaxial_2d) {
  check_biaxial<2>();
}
TEST(V14_Strength, biaxial_3d) {
  check_biaxial<3>();
}

}  // namespace
}  // namespace gabion::test
