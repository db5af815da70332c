// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/grid/point_inertia.hpp"

#include <algorithm>
#include <array>

#include "mpm_solver/grid/transfer.hpp"

namespace gabion::mpm {

namespace {

/// Shares of a point in the masses of its nodes, and its own mass.
struct PointMass {
  const double* rho;
  double m;
};

// out_i += rho_i sum_j rho_j in_j / m for one point.
// @tparam num_nodes  where the nodes stand in order: their number
template <int dim, int num_nodes>
inline void add_response(int given, const std::uint8_t* local, const PointMass& point,
                         const double* in, double* out) {
  const int n = num_nodes > 0 ? num_nodes : given;
  Vector<dim> dv = Vector<dim>::Zero();
  for (int i = 0; i < n; ++i) {
    dv += point.rho[i] * Eigen::Map<const Vector<dim>>(in + (num_nodes > 0 ? i : local[i]) * dim);
  }
  dv /= point.m;
  for (int i = 0; i < n; ++i) {
    Eigen::Map<Vector<dim>>(out + (num_nodes > 0 ? i : local[i]) * dim) += point.rho[i] * dv;
  }
}

bool all_zero(const double* values, std::size_t count) {
  return std::all_of(values, values + count, [](double value) { return value == 0; });
}

}  // namespace

template <int dim>
PointInertia<dim>::PointInertia(const MaterialPoints<dim>& points, const PointWeights<dim>& weights,
                                const GridNodes<dim>& nodes)
    : points_(points), weights_(weights), nodes_(nodes), weightless_(weightless_mass(nodes)) {
  any_weightless_ =
      std::any_of(nodes.m.begin(), nodes.m.end(), [&](double m) { return m <= weightless_; });
  std::vector<double> mass = nodes.m;
  std::int32_t active[max_group_nodes<dim>];
  const auto for_each_value = [&](const auto& visit) {
    for (const CellGroup& group : weights.groups) {
      nodes.list_active(weights.nodes_of(group), active);
      for (std::int32_t e = group.first; e < group.last; ++e) {
        const double m = points.m[weights.point[e]];
        const std::uint8_t* local = weights.local_of(e);
        for (int i = 0; i < weights.num_nodes(e); ++i) {
          const std::int32_t node = active[local[i]];
          visit(node, is_weightless(node) ? m : weights.N_of(e)[i] * m);
        }
      }
    }
  };
  if (!nodes.shared.all(!any_weightless_)) {
    std::vector<double> reach(mass.size(), 0);
    for_each_value([&](std::int32_t node, double m) { reach[node] += m; });
    nodes.shared.sum(reach, 1);
    for (std::int32_t i = 0; i < nodes.size(); ++i) {
      if (is_weightless(i)) mass[i] = reach[i];
    }
  }
  rho_.reserve(weights.N.size());
  for_each_value([&](std::int32_t node, double m) { rho_.push_back(m / mass[node]); });
}

template <int dim>
void PointInertia<dim>::add_responses(const CellGroup& group, std::span<const double> impulse,
                                      std::span<double> dv) const {
  std::array<double, max_group_nodes<dim> * dim> in, out;
  std::int32_t active[max_group_nodes<dim>];
  const auto grid_nodes = weights_.nodes_of(group);
  nodes_.gather(grid_nodes, impulse, in.data());
  if (all_zero(in.data(), grid_nodes.size() * dim)) return;
  nodes_.list_active(grid_nodes, active);
  std::fill_n(out.begin(), grid_nodes.size() * dim, 0.0);
  const double* rho = rho_of(group);
  for (std::int32_t e = group.first; e < group.last; ++e) {
    const int n = weights_.num_nodes(e);
    const double m = points_.m[weights_.point[e]];
    if (weights_.whole_cells && n == (1 << dim)) {
      add_response<dim, (1 << dim)>(n, nullptr, {rho, m}, in.data(), out.data());
    } else {
      add_response<dim, 0>(n, weights_.local_of(e), {rho, m}, in.data(), out.data());
    }
    rho += n;
  }
  for (std::size_t i = 0; i < grid_nodes.size(); ++i) {
    for (int d = 0; d < dim; ++d) dv[std::size_t(active[i]) * dim + d] += out[i * dim + d];
  }
}

template <int dim>
void PointInertia<dim>::apply(std::span<const double> impulse, std::span<double> dv) const {
  std::fill(dv.begin(), dv.end(), 0.0);
  for (const CellGroup& group : weights_.groups) add_responses(group, impulse, dv);
  nodes_.shared.sum(dv, dim);
}

template <int dim>
void PointInertia<dim>::apply_to(std::span<const std::int32_t> groups,
                                 std::span<const double> impulse, std::span<double> dv) const {
  std::fill(dv.begin(), dv.end(), 0.0);
  for (const std::int32_t g : groups) add_responses(weights_.groups[g], impulse, dv);
  nodes_.shared.sum(dv, dim);
}

template <int dim>
void PointInertia<dim>::add_rows(std::span<const std::int32_t> starts,
                                 std::span<const std::int32_t> columns,
                                 std::span<double> values) const {
  std::int32_t active[max_group_nodes<dim>];
  for (const CellGroup& group : weights_.groups) {
    nodes_.list_active(weights_.nodes_of(group), active);
    const double* rho = rho_of(group);
    for (std::int32_t e = group.first; e < group.last; ++e) {
      const int n = weights_.num_nodes(e);
      const double m = points_.m[weights_.point[e]];
      const std::uint8_t* local = weights_.local_of(e);
      for (int i = 0; i < n; ++i) {
        const std::int32_t row = active[local[i]];
        const auto begin = columns.begin() + starts[row], end = columns.begin() + starts[row + 1];
        for (int k = 0; k < n; ++k) {
          const auto place = std::lower_bound(begin, end, active[local[k]]);
          values[place - columns.begin()] += rho[i] * rho[k] / m;
        }
      }
      rho += n;
    }
  }
}

template <int dim>
double PointInertia<dim>::largest_rate(std::span<const double> row_sums) const {
  double largest = 0;
  std::int32_t active[max_group_nodes<dim>];
  for (const CellGroup& group : weights_.groups) {
    nodes_.list_active(weights_.nodes_of(group), active);
    if (std::all_of(active, active + group.num_nodes,
                    [&](std::int32_t node) { return row_sums[node] == 0; })) {
      continue;
    }
    const double* rho = rho_of(group);
    for (std::int32_t e = group.first; e < group.last; ++e) {
      const std::uint8_t* local = weights_.local_of(e);
      double sum = 0;
      for (int i = 0; i < weights_.num_nodes(e); ++i) sum += *rho++ * row_sums[active[local[i]]];
      largest = std::max(largest, sum / points_.m[weights_.point[e]]);
    }
  }
  return nodes_.shared.largest(largest);
}

template <int dim>
void PointInertia<dim>::kick_from_weightless(std::span<const double> impulse, double share,
                                             MaterialPoints<dim>& points) const {
  if (!any_weightless_) return;
  const double* rho = rho_.data();
  std::int32_t active[max_group_nodes<dim>];
  for (const CellGroup& group : weights_.groups) {
    nodes_.list_active(weights_.nodes_of(group), active);
    for (std::int32_t e = group.first; e < group.last; ++e) {
      const std::int32_t p = weights_.point[e];
      for (int i = 0; i < weights_.num_nodes(e); ++i, ++rho) {
        const std::int32_t node = active[weights_.local_of(e)[i]];
        if (!is_weightless(node)) continue;
        const Eigen::Map<const Vector<dim>> I(impulse.data() + std::ptrdiff_t{node} * dim);
        points.v[p] += share * *rho / points.m[p] * I;
      }
    }
  }
}

template class PointInertia<2>;
template class PointInertia<3>;

}  // namespace gabion::mpm
