// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/step/pressure_matrix.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

namespace gabion::mpm {

template <int dim>
PressureMatrix<dim>::PressureMatrix(const Parts& parts, const BlockMatrix<dim + 1>& K, double dt) {
  constexpr int n = dim + 1;
  S_.starts.assign(K.row_starts().begin(), K.row_starts().end());
  S_.columns.assign(K.columns().begin(), K.columns().end());
  S_.values.resize(S_.columns.size());
  for (std::size_t s = 0; s < S_.values.size(); ++s) {
    S_.values[s] = -K.values()[s * n * n + dim * n + dim];
  }
  list_pushes(parts);
  find_responses(parts);
  for (double& value : M_.values) value *= dt * dt;
}

template <int dim>
void PressureMatrix<dim>::list_pushes(const Parts& parts) {
  const auto& weights = parts.stress.weights;
  pushes_.starts.push_back(0);
  std::int32_t active[max_group_nodes<dim>];
  for (const CellGroup& group : weights.groups) {
    const auto& water = parts.stress.bodies[group.body].water;
    if (!water || !water->drains()) continue;
    parts.stress.nodes.list_active(weights.nodes_of(group), active);
    double V_group = 0;
    for (std::int32_t e = group.first; e < group.last; ++e) {
      const double V = weights.volume[e] * parts.stress.points.J[weights.point[e]];
      if (!parts.averages || e == group.first) {
        pushes_.nodes.insert(pushes_.nodes.end(), active, active + group.num_nodes);
        pushes_.N.resize(pushes_.nodes.size(), 0.0);
        pushes_.c.resize(pushes_.nodes.size(), Vector<dim>::Zero());
      }
      const std::size_t first = pushes_.nodes.size() - group.num_nodes;
      for (int i = 0; i < weights.num_nodes(e); ++i) {
        const std::size_t k = first + weights.local_of(e)[i];
        pushes_.N[k] += (parts.averages ? V : 1) * weights.N_of(e)[i];
        pushes_.c[k] += V * weights.grad_of(e)[i];
      }
      V_group += V;
      if (parts.averages && e + 1 < group.last) continue;
      for (std::size_t k = first; parts.averages && k < pushes_.N.size(); ++k) {
        pushes_.N[k] /= V_group;
      }
      pushes_.starts.push_back(static_cast<std::int32_t>(pushes_.nodes.size()));
    }
  }
}

template <int dim>
void PressureMatrix<dim>::change(const StressParts<dim>& parts,
                                 std::span<const OutletChange> outlets) {
  const auto& weights = parts.weights;
  std::int32_t active[max_group_nodes<dim>];
  for (const auto& [entry, w, drained] : outlets) {
    const auto next = std::ranges::upper_bound(weights.groups, entry, {}, &CellGroup::first);
    parts.nodes.list_active(weights.nodes_of(*std::prev(next)), active);
    const std::uint8_t* local = weights.local_of(entry);
    for (int i = 0; i < weights.num_nodes(entry); ++i) {
      const std::int32_t row = active[local[i]];
      const auto begin = S_.columns.begin() + S_.starts[row];
      const auto end = S_.columns.begin() + S_.starts[row + 1];
      for (int k = 0; k < weights.num_nodes(entry); ++k) {
        const auto place = std::lower_bound(begin, end, active[local[k]]);
        S_.values[place - S_.columns.begin()] += drained * w[i] * w[k];
      }
    }
  }
}

// M, row by row: the response of the nodes to a pressure, and what it does to the others.
template <int dim>
void PressureMatrix<dim>::find_responses(const Parts& parts) {
  const std::size_t num = pushes_.starts.size() - 1, num_nodes = S_.starts.size() - 1;
  SparseRows W{S_.starts, S_.columns, std::vector<double>(S_.columns.size(), 0.0)};
  parts.inertia.add_rows(W.starts, W.columns, W.values);
  std::vector<Matrix<dim>> Q(num_nodes, Matrix<dim>::Identity());
  for (std::size_t k = 0; k < parts.walls.constrained().size(); ++k) {
    Q[parts.walls.constrained()[k]] = parts.walls.projectors()[k];
  }
  std::vector<Vector<dim>> free(pushes_.c.size());       // Q c
  std::vector<std::vector<std::int32_t>> at(num_nodes);  // places in the pushes of each node
  std::vector<std::int32_t> push_of(pushes_.nodes.size());
  for (std::size_t g = 0; g < num; ++g) {
    for (std::int32_t k = pushes_.starts[g]; k < pushes_.starts[g + 1]; ++k) {
      free[k] = Q[pushes_.nodes[k]] * pushes_.c[k];
      at[pushes_.nodes[k]].push_back(k);
      push_of[k] = static_cast<std::int32_t>(g);
    }
  }
  std::vector<Vector<dim>> moved(num_nodes, Vector<dim>::Zero());
  std::vector<double> row(num, 0.0);
  std::vector<char> met(num_nodes, 0), reached(num, 0);
  std::vector<std::int32_t> nodes, columns;
  M_.starts.assign(1, 0);
  for (std::size_t g = 0; g < num; ++g) {
    nodes.clear();
    columns.clear();
    for (std::int32_t k = pushes_.starts[g]; k < pushes_.starts[g + 1]; ++k) {
      const std::int32_t i = pushes_.nodes[k];
      for (std::int32_t s = W.starts[i]; s < W.starts[i + 1]; ++s) {
        const std::int32_t j = W.columns[s];
        if (std::exchange(met[j], 1) == 0) nodes.push_back(j);
        moved[j] += W.values[s] * free[k];
      }
    }
    for (const std::int32_t j : nodes) {
      for (const std::int32_t k : at[j]) {
        const std::int32_t h = push_of[k];
        if (std::exchange(reached[h], 1) == 0) columns.push_back(h);
        row[h] += free[k].dot(moved[j]);
      }
      moved[j].setZero();
      met[j] = 0;
    }
    std::ranges::sort(columns);
    for (const std::int32_t h : columns) {
      M_.columns.push_back(h);
      M_.values.push_back(std::exchange(row[h], 0.0));
      reached[h] = 0;
    }
    M_.starts.push_back(static_cast<std::int32_t>(M_.columns.size()));
  }
}

template <int dim>
void PressureMatrix<dim>::multiply(std::span<const double> q, std::span<const char> held,
                                   std::span<double> r) const {
  const std::size_t num = pushes_.starts.size() - 1;
  std::vector<double> p(num, 0.0);
  for (std::size_t g = 0; g < num; ++g) {
    for (std::int32_t k = pushes_.starts[g]; k < pushes_.starts[g + 1]; ++k) {
      p[g] += pushes_.N[k] * q[pushes_.nodes[k]];
    }
  }
  for (std::size_t i = 0; i < q.size(); ++i) {
    double sum = 0;
    for (std::int32_t s = S_.starts[i]; s < S_.starts[i + 1]; ++s) {
      sum += S_.values[s] * q[S_.columns[s]];
    }
    r[i] = sum;
  }
  for (std::size_t g = 0; g < num; ++g) {
    double sum = 0;
    for (std::int32_t s = M_.starts[g]; s < M_.starts[g + 1]; ++s) {
      sum += M_.values[s] * p[M_.columns[s]];
    }
    for (std::int32_t k = pushes_.starts[g]; k < pushes_.starts[g + 1]; ++k) {
      r[pushes_.nodes[k]] += pushes_.N[k] * sum;
    }
  }
  for (std::size_t i = 0; i < q.size(); ++i) {
    if (held[i] != 0) r[i] = q[i];
  }
}

template <int dim>
void PressureMatrix<dim>::add_forces(std::span<const double> q, std::span<double> f) const {
  for (std::size_t g = 0; g + 1 < pushes_.starts.size(); ++g) {
    double p = 0;
    for (std::int32_t k = pushes_.starts[g]; k < pushes_.starts[g + 1]; ++k) {
      p += pushes_.N[k] * q[pushes_.nodes[k]];
    }
    for (std::int32_t k = pushes_.starts[g]; k < pushes_.starts[g + 1]; ++k) {
      for (int d = 0; d < dim; ++d) {
        f[static_cast<std::size_t>(pushes_.nodes[k]) * dim + d] += p * pushes_.c[k][d];
      }
    }
  }
}

template <int dim>
SparseRows PressureMatrix<dim>::near(std::span<const char> held, bool lump) const {
  SparseRows near = S_;
  const std::size_t num_nodes = held.size();
  std::vector<double> row(num_nodes, 0.0), left_out(num_nodes, 0.0);
  std::vector<std::int32_t> met;
  for (std::size_t g = 0; g + 1 < pushes_.starts.size(); ++g) {
    met.clear();
    double size = 0;
    for (std::int32_t s = M_.starts[g]; s < M_.starts[g + 1]; ++s) {
      const auto h = static_cast<std::size_t>(M_.columns[s]);
      for (std::int32_t k = pushes_.starts[h]; k < pushes_.starts[h + 1]; ++k) {
        met.push_back(pushes_.nodes[k]);
        row[pushes_.nodes[k]] += M_.values[s] * pushes_.N[k];
        size += std::abs(M_.values[s] * pushes_.N[k]);
      }
    }
    for (std::int32_t k = pushes_.starts[g]; k < pushes_.starts[g + 1]; ++k) {
      const std::int32_t i = pushes_.nodes[k];
      double kept = 0;
      for (std::int32_t s = near.starts[i]; s < near.starts[i + 1]; ++s) {
        near.values[s] += pushes_.N[k] * row[near.columns[s]];
        kept += std::abs(row[near.columns[s]]);
      }
      left_out[i] += std::abs(pushes_.N[k]) * std::max(0.0, size - kept);
    }
    for (const std::int32_t j : met) row[j] = 0;
  }
  for (std::size_t i = 0; i < num_nodes; ++i) {
    for (std::int32_t s = near.starts[i]; s < near.starts[i + 1]; ++s) {
      const auto k = static_cast<std::size_t>(near.columns[s]);
      if (k == i && lump) near.values[s] += left_out[i];
      if (held[i] != 0 || held[k] != 0) near.values[s] = i == k ? 1 : 0;
    }
  }
  return near;
}

template class PressureMatrix<2>;
template class PressureMatrix<3>;

}  // namespace gabion::mpm
