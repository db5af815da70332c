// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "common/mechanics/tensor.hpp"
#include "mpm_solver/parameters/counted_random.hpp"

namespace gabion::mpm {

/// Cells of a random field: equal boxes that fill a box.
template <int dim>
struct RandomLattice {
  /// @param step  largest edges of a cell [m]
  RandomLattice(const Eigen::AlignedBox<double, dim>& box, const Vector<dim>& step);

  std::int64_t num_cells() const;
  /// The cell that holds x, of places outside the box the nearest one.
  std::int64_t cell_of(const Vector<dim>& x) const;

  Vector<dim> low;               ///< corner [m]
  Vector<dim> step;              ///< edges of a cell [m]
  std::array<int, dim> count{};  ///< of cells along each axis
};

/// More cells would cost more memory and time than a run should spend on a field.
inline constexpr std::int64_t most_random_cells = 200'000'000;

/// A normal field of mean 0 and deviation 1 with Markov's correlation (Vanmarcke 1983),
///
///     rho(d) = exp(-2 sum_k |d_k| / theta_k) ,
///
/// at the centres of the cells of a lattice; each cell has the value of its centre. The correlation
/// is a product over the axes, and along each axis the field is a Markov chain: independent numbers
/// that go through
///
///     Z_i = a Z_(i-1) + sqrt(1 - a^2) W_i ,   a = exp(-2 step / theta)
///
/// along one axis after the other have exactly this correlation. The independent number of a cell
/// follows from seed, stream and the number of the cell.
/// @returns values of the cells, the last axis fastest
template <int dim>
std::vector<double> normal_field(const RandomLattice<dim>& lattice,
                                 const Vector<dim>& correlation_lengths,
                                 const CountedRandom& random);

/// Mean and deviation of the logarithm of a lognormal variable.
struct Lognormal {
  double mean, deviation;
  /// @param mean  of the variable, > 0
  /// @param cov   its deviation over its mean
  static Lognormal of(double mean, double cov);
  /// Value where the normal field is z.
  double at(double z) const;
};

}  // namespace gabion::mpm
