// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>

#include "common/mechanics/materials/spectral.hpp"
#include "fem_solver/materials/green_stress.hpp"

namespace gabion::fem {

/// Logarithmic strain E = 1/2 ln C with the axes of C. A law of small strain between E and its dual
/// stress T is a law of finite strain: rotations drop out, and history stays on fixed axes.
/// @see Miehe, Apel and Lambrecht (2002)
template <int dim>
struct LogStrain {
  Symmetric<dim> E;                   ///< zz of plane strain is 0
  std::array<double, dim> stretch_2;  ///< eigenvalues of C
  Matrix<dim> N;                      ///< its axes, as columns
};

/// Response of a law to E.
template <int dim>
struct LogStress {
  Symmetric<dim> T;     ///< dual to E [Pa]
  StrainMatrix<dim> D;  ///< dT/dE of the components on the dim axes [Pa], symmetric
  double energy = 0;    ///< elastic, per reference volume [J/m^3]
};

/// @param twice_E  C - 1
/// @returns        false when C is not positive definite
template <int dim>
bool find_log_strain(const Matrix<dim>& twice_E, LogStrain<dim>& out);
/// The logarithmic strain from E itself.
template <int dim>
LogStrain<dim> log_strain_of(const Symmetric<dim>& E);

/// U^exponent of C = U U: its stretch, or the inverse.
template <int dim>
Matrix<dim> stretch(const LogStrain<dim>& strain, int exponent);

/// Derivative of E by the Green strain, symmetric.
template <int dim>
StrainMatrix<dim> log_by_green(const LogStrain<dim>& strain);

/// S = T : dE/dE_green, and on demand its derivative by the Green strain.
/// @param slopes  log_by_green()
template <int dim>
GreenStress<dim> turned_to_green(const LogStrain<dim>& strain, const StrainMatrix<dim>& slopes,
                                 const LogStress<dim>& stress, bool with_tangent);

/// Second divided difference of ln(x) / 2, with its limits where values meet; all > 0.
double log_curvature(double x, double y, double z);

}  // namespace gabion::fem
