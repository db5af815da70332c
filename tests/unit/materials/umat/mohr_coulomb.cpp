// SPDX-License-Identifier: BSD-3-Clause
// The project's own Mohr-Coulomb as a user material: PROPS lambda, mu [Pa], phi, psi [rad], c [Pa];
// STATEV accumulated plastic strain and opened volume.
#include "common/mechanics/materials/mohr_coulomb.hpp"

#include <Eigen/LU>

#include "common/mechanics/materials/spectral.hpp"

namespace {

using namespace gabion;
using Eigen::Matrix3d;

// Tensor of NTENS components in the order of Abaqus.
Matrix3d tensor(const double* s, int n, double shear) {
  Matrix3d m = Eigen::Vector3d(s[0], s[1], s[2]).asDiagonal();
  m(0, 1) = m(1, 0) = shear * s[3];
  if (n > 4) {
    m(0, 2) = m(2, 0) = shear * s[4];
    m(1, 2) = m(2, 1) = shear * s[5];
  }
  return m;
}

struct Point {
  const double* props;
  Matrix3d sigma_n;  // already turned
  double J_n;
  MaterialState<3> state;
};

// The stress at the end of an increment of strain; the state too if it is wanted.
bool solve(const Point& point, const Matrix3d& strain, Matrix3d& sigma, MaterialState<3>* end) {
  const double* p = point.props;
  const MohrCoulomb<3> law(p[0], p[1], p[2], p[3], p[4]);
  // elastic strain of the stress: b_e = exp(2 eps)
  const Matrix3d tau = point.J_n * point.sigma_n;
  const Eigenpairs<3> axes = eigenpairs<3>(symmetric<3>(tau));
  const double mean = (axes.value[0] + axes.value[1] + axes.value[2]) / 3;
  std::array<double, 3> e;
  for (int i = 0; i < 3; ++i) {
    e[i] = strain_from_hencky((axes.value[i] - mean) / (2 * p[1]) + mean / (3 * p[0] + 2 * p[1]));
  }
  MaterialState<3> state = point.state;
  state.e = compose<3>(e, axes.n);
  // the stretch of the increment
  const Eigenpairs<3> of_strain = eigenpairs<3>(symmetric<3>(strain));
  std::array<double, 3> stretch;
  for (int i = 0; i < 3; ++i) stretch[i] = std::expm1(of_strain.value[i]);
  const Matrix3d H = in_plane<3>(compose<3>(stretch, of_strain.n));
  StressUpdate<3> out;
  if (!law.update(H, state, out, nullptr)) return false;
  sigma = in_plane<3>(out.tau) / (point.J_n * std::exp(strain.trace()));
  if (end != nullptr) *end = out.state;
  return true;
}

}  // namespace

extern "C" void umat_(double* stress, double* statev, double* ddsdde, double*, double*, double*,
                      double*, double*, double*, double*, const double*, const double* dstran,
                      const double*, const double*, const double*, const double*, const double*,
                      const double*, const char*, const int*, const int*, const int* ntens,
                      const int*, const double* props, const int*, const double*, const double*,
                      double* pnewdt, const double*, const double* dfgrd0, const double*,
                      const int*, const int*, const int*, const int*, const int*, const int*,
                      std::size_t) {
  const int n = *ntens;
  Point point{.props = props,
              .sigma_n = tensor(stress, n, 1),
              .J_n = Eigen::Map<const Matrix3d>(dfgrd0).determinant(),
              .state = {.plastic_strain = statev[0], .gap = statev[1]}};
  Matrix3d sigma;
  MaterialState<3> end;
  if (!solve(point, tensor(dstran, n, 0.5), sigma, &end)) {
    *pnewdt = 0.5;
    return;
  }
  statev[0] = end.plastic_strain;
  statev[1] = end.gap;
  constexpr int row[] = {0, 1, 2, 0, 0, 1}, column[] = {0, 1, 2, 1, 2, 2};
  constexpr double change = 1e-7;
  for (int l = 0; l < n; ++l) {
    Matrix3d up, down;
    double strain[6];
    std::copy_n(dstran, n, strain);
    strain[l] += change;
    const bool first = solve(point, tensor(strain, n, 0.5), up, nullptr);
    strain[l] -= 2 * change;
    if (!first || !solve(point, tensor(strain, n, 0.5), down, nullptr)) *pnewdt = 0.5;
    for (int k = 0; k < n; ++k) ddsdde[k + n * l] = (up - down)(row[k], column[k]) / (2 * change);
  }
  for (int k = 0; k < n; ++k) stress[k] = sigma(row[k], column[k]);
}
