// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <type_traits>

#include "mpm_solver/grid/basis.hpp"
#include "mpm_solver/stress/point_terms.hpp"

namespace gabion::mpm {

/// Vectors at the nodes of one cell, summed up over its points: sum_J nodal_J grad_iJ of each.
/// @tparam num_nodes  where all nodes act on all points (PointWeights::whole_cells): their number
template <int dim, int num_fields, int num_nodes = 0>
class NodalSums {
 public:
  static constexpr int width = PointTerms<dim, num_fields>::width;

  void start(int n) { std::fill_n(x_, n * width, 0.0); }

  /// @param given, local, grad  values of a point: their number, each one's node and gradient
  /// @param nodal               see PointTerms, [J][width]
  void add(int given, const std::uint8_t* local, const Vector<dim>* grad, const double* nodal) {
    const int n = num_nodes > 0 ? num_nodes : given;
    using Piece = std::conditional_t<width == 2, Pair, Lanes>;
    constexpr int size = sizeof(Piece) / sizeof(double);
    for (int i = 0; i < n; ++i) {
      double* at = x_ + (num_nodes > 0 ? i : local[i]) * width;
      for (int c = 0; c < width; c += size) {
        Piece sum;
        std::memcpy(&sum, at + c, sizeof sum);
        for (int J = 0; J < dim; ++J) {
          Piece term;
          std::memcpy(&term, nodal + J * width + c, sizeof term);
          sum += term * grad[i][J];
        }
        std::memcpy(at + c, &sum, sizeof sum);
      }
    }
  }

  /// The first field of all nodes added to a field of the grid. @param active  their numbers there
  void scatter(int n, const std::int32_t* active, double* field) const {
    for (int i = 0; i < n; ++i) {
      double* at_node = field + static_cast<std::ptrdiff_t>(active[i]) * dim;
      for (int a = 0; a < dim; ++a) at_node[a] += x_[i * width + a];
    }
  }
  /// Copy one field, n x dim.
  void take(int n, int field, double* to) const {
    for (int i = 0; i < n; ++i) {
      for (int a = 0; a < dim; ++a) to[i * dim + a] = x_[i * width + field * dim + a];
    }
  }

 private:
  using Pair = double __attribute__((vector_size(16)));

  double x_[max_group_nodes<dim> * width];
};

}  // namespace gabion::mpm
