// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <optional>

#include "coupler/mapping/surface.hpp"

namespace gabion {

/// Radial functions phi(r), r in units of the support (Wendland) or of the cluster's radius.
enum class Kernel {
  wendland_c2,  ///< (1 - r)^4 (4 r + 1) up to r = 1, then 0
  wendland_c4,  ///< (1 - r)^6 (35 r^2 + 18 r + 3) / 3 up to r = 1, then 0
  wendland_c6,  ///< (1 - r)^8 (32 r^3 + 25 r^2 + 8 r + 1) up to r = 1, then 0
  thin_plate    ///< r^2 ln r
};

struct RadialBasisSettings {
  Kernel kernel = Kernel::wendland_c4;
  int cluster_size = 50;  ///< vertices that one interpolant uses, >= 4
  /// Radius of the Wendland functions [m] > 0; not set: largest extent of the surface along an
  /// axis.
  std::optional<double> support = {};
};

/// Weights of an interpolation by radial functions with a linear polynomial, in a partition of
/// unity: around a centre c the `cluster_size` nearest vertices carry one interpolant s_c each, and
///
///     u(x) = sum_c w_c(x) s_c(x),   w_c proportional to Wendland's C2 function of |x - c| / R_c
///
/// Work and memory grow linearly with the surface. The thin plate has no length of its own, so the
/// error is of order 2, that of the polynomial; with Wendland functions whose support does not
/// shrink with the mesh it is higher for C4 and C6, about 3.3 and 3.8, until rounding stops it
/// (support / vertex distance above about 1000 for C4, 100 for C6). Interpolates at the vertices of
/// `from`. Linear fields are kept in every direction in which a cluster extends; in one in which it
/// is flat (less than 1e-3 of its size) the field is taken as constant.
///
/// @param from  where values are given
/// @param to    where they are wanted
/// @returns     num_vertices of `to` x num_vertices of `from`
/// @throws ConfigError  the vertices of `from` do not determine an interpolant, or not to 1e-9
/// @see Wendland (2005), Scattered Data Approximation, chapters 9, 11 and 15
Eigen::SparseMatrix<double, Eigen::RowMajor> radial_basis_weights(const Surface& from,
                                                                  const Surface& to,
                                                                  RadialBasisSettings settings);

/// phi(r), r >= 0.
double radial_function(Kernel kernel, double r);

}  // namespace gabion
