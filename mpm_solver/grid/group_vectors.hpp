// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cstring>
#include <span>
#include <type_traits>

#include "common/mechanics/simd/lanes.hpp"
#include "mpm_solver/grid/entry_values.hpp"
#include "mpm_solver/grid/grid_nodes.hpp"

namespace gabion::mpm {

/// A vector x_i of each node of a group of points.
/// @tparam num_nodes  see EntryValues
template <int dim, int num_nodes>
class GroupVectors {
 public:
  void set_zero(int n) { std::fill_n(x_, n, Padded{}); }
  /// @param field  of all active nodes, dim each
  void gather(const GridNodes<dim>& nodes, const GroupNodes& group, std::span<const double> field) {
    for (std::size_t i = 0; i < group.size(); ++i) {
      const std::ptrdiff_t node = nodes.of_groups[group.first + i];
      x_[i] = padded(field.data() + node * dim);
    }
  }
  /// Add them to a field of all active nodes.
  void scatter(const GridNodes<dim>& nodes, const GroupNodes& group,
               std::span<double> field) const {
    for (std::size_t i = 0; i < group.size(); ++i) {
      const std::ptrdiff_t node = nodes.of_groups[group.first + i];
      for (int d = 0; d < dim; ++d) field[node * dim + d] += x_[i][d];
    }
  }

  /// x_i += N_ip b of the point of an entry.
  void add(const PointWeights<dim>& weights, std::int32_t entry, const Vector<dim>& b) {
    const EntryValues<dim, num_nodes> values(weights, entry);
    const Padded of_point = padded(b.data());
    for (int i = 0; i < values.size(); ++i) x_[values.number(i)] += values.N[i] * of_point;
  }
  /// sum_i N_ip x_i
  Vector<dim> at_point(const PointWeights<dim>& weights, std::int32_t entry) const {
    const EntryValues<dim, num_nodes> values(weights, entry);
    Padded sum{};
    for (int i = 0; i < values.size(); ++i) sum += values.N[i] * x_[values.number(i)];
    Vector<dim> x;
    for (int d = 0; d < dim; ++d) x[d] = sum[d];
    return x;
  }
  /// |sum_i x_i (x) grad N_ip|^2
  double squared_gradient(const PointWeights<dim>& weights, std::int32_t entry) const {
    const EntryValues<dim, num_nodes> values(weights, entry);
    Padded columns[dim] = {};
    for (int i = 0; i < values.size(); ++i) {
      for (int J = 0; J < dim; ++J) columns[J] += values.grad[i][J] * x_[values.number(i)];
    }
    Padded squares{};
    for (const Padded& column : columns) squares += column * column;
    double sum = 0;
    for (int d = 0; d < dim; ++d) sum += squares[d];
    return sum;
  }

 private:
  using Pair = double __attribute__((vector_size(16)));
  using Padded = std::conditional_t<dim == 2, Pair, Lanes>;

  static Padded padded(const double* x) {
    Padded r{};
    std::memcpy(&r, x, dim * sizeof(double));
    return r;
  }

  Padded x_[max_group_nodes<dim>];
};

}  // namespace gabion::mpm
