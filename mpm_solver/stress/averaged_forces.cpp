// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/stress/averaged_forces.hpp"

#include <algorithm>
#include <tuple>
#include <variant>

#include "common/base/require.hpp"
#include "common/mechanics/tensor_functions.hpp"

namespace gabion::mpm {

namespace {

constexpr int batch_size = num_lanes;

}  // namespace

template <int dim>
void AveragedForces<dim>::start(const GroupRange& range) {
  const CellGroup* groups = parts_.weights.groups.data();
  stresses_.start(parts_.weights, range);
  averages_.resize(stresses_.batches().size());
  sums_.assign(range.last - range.first, {});
  group_of_.resize(averages_.size() * batch_size);
  auto next = group_of_.begin();
  for (std::int32_t g = range.first; g < range.last; ++g) {
    next = std::fill_n(next, groups[g].last - groups[g].first, g - range.first);
  }
  std::fill(next, group_of_.end(), range.last - 1 - range.first);
}

// Volumes of the points, from the gradients that are set.
template <int dim>
void AveragedForces<dim>::set_volumes() {
  stresses_.fill_up();
  const auto& [points, weights] = std::tie(parts_.points, parts_.weights);
  for (std::size_t b = 0; b < averages_.size(); ++b) {
    const Lanes V = stresses_.of_points(
        b, [&](std::int32_t e) { return weights.volume[e] * points.J[weights.point[e]]; });
    averages_[b].start(stresses_.batches()[b].H, V, parts_.held_normal);
    for (int l = 0; l < stresses_.points_of(b); ++l) {
      GroupSums& sums = sums_[group_of_[b * batch_size + l]];
      sums.before += averages_[b].V(l);
      sums.change += averages_[b].V_change(l);
    }
  }
}

template <int dim>
template <int n>
bool AveragedForces<dim>::find_volumes(const GroupRange& range, std::span<const double> du,
                                       RefusedPoint& worst) {
  start(range);
  stresses_.template set_gradients<n>(parts_, range, du);
  set_volumes();
  for (std::size_t b = 0; b < averages_.size(); ++b) {
    const LaneMask refused = averages_[b].J() < min_J_ratio;
    if (!any(refused)) continue;
    int lane = 0;
    while (!refused[lane]) ++lane;
    worst = {parts_.weights.point[stresses_.entry(b, lane)], Refusal::squeezed};
    return false;
  }
  return true;
}

// A number of the group of each point of a batch.
template <int dim>
template <class OfGroup>
Lanes AveragedForces<dim>::of_groups(std::size_t b, const OfGroup& of_group) const {
  Lanes x;
  for (int l = 0; l < batch_size; ++l) x[l] = of_group(sums_[group_of_[b * batch_size + l]], l);
  return x;
}

template <int dim>
template <class Law>
bool AveragedForces<dim>::find_stresses(const Law& law, bool with_K, RefusedPoint& worst) {
  for (std::size_t b = 0; b < averages_.size(); ++b) {
    const Lanes mean_change =
        of_groups(b, [](const GroupSums& sums, int) { return sums.change / sums.before; });
    averages_[b].average(mean_change, stresses_.batches()[b].H);
  }
  if (!stresses_.evaluate(parts_, law, with_K, worst)) return false;
  sum_pressures(with_K);
  return true;
}

template <int dim>
void AveragedForces<dim>::sum_pressures(bool with_K) {
  for (std::size_t b = 0; b < averages_.size(); ++b) {
    averages_[b].set_stress(stresses_.V0(parts_, b), stresses_.batches()[b], with_K);
    for (int l = 0; l < stresses_.points_of(b); ++l) {
      GroupSums& sums = sums_[group_of_[b * batch_size + l]];
      sums.pressure += averages_[b].pressure(l);
      if (with_K) sums.coupling += averages_[b].coupling(l);
    }
  }
}

// Order the terms of the points in the forces, or in all.
template <int dim>
void AveragedForces<dim>::order_forces() {
  force_terms_.resize(averages_.size() * batch_size);
  for (std::size_t b = 0; b < averages_.size(); ++b) {
    const Batch& average = averages_[b];
    const Lanes mean_pressure = of_groups(b, [&](const GroupSums& sums, int l) {
      return sums.share(average.V(l), average.V_change(l)) * sums.pressure;
    });
    average.share_forces(mean_pressure, &force_terms_[b * batch_size]);
  }
}

template <int dim>
void AveragedForces<dim>::order_all() {
  terms_.resize(averages_.size() * batch_size);
  for (std::size_t b = 0; b < averages_.size(); ++b) {
    const Batch& average = averages_[b];
    const Lanes share = of_groups(b, [&](const GroupSums& sums, int l) {
      return sums.share(average.V(l), average.V_change(l));
    });
    const Lanes mean_pressure =
        share * of_groups(b, [](const GroupSums& sums, int) { return sums.pressure; });
    average.share_all(share, mean_pressure, stresses_.batches()[b].A, &terms_[b * batch_size]);
  }
}

template <int dim>
template <int n>
void AveragedForces<dim>::add_forces(const GroupRange& range, std::span<double> f) {
  order_forces();
  const auto& weights = parts_.weights;
  CellSums<dim, 1, n> sums;
  const PointTerms<dim, 1>* terms = force_terms_.data();
  for (std::int32_t g = range.first; g < range.last; ++g) {
    const CellGroup& group = weights.groups[g];
    sums.start(group.num_nodes);
    for (std::int32_t e = group.first; e < group.last; ++e) sums.add_forces(weights, e, *terms++);
    sums.scatter(parts_, group, f.data());
  }
}

template <int dim>
template <int n>
void AveragedForces<dim>::add_all(const GroupRange& range, BlockMatrix<dim>& K,
                                  std::span<double> f) {
  order_all();
  CellSums<dim, Batch::num_fields, n> sums;
  for (std::int32_t g = range.first; g < range.last; ++g) {
    add_cell<n>(g, sums, K);
    sums.scatter(parts_, parts_.weights.groups[g], f.data());
  }
}

template <int dim>
template <int n>
void AveragedForces<dim>::add_cell(std::int32_t g, CellSums<dim, Batch::num_fields, n>& sums,
                                   BlockMatrix<dim>& K) {
  const auto& weights = parts_.weights;
  const CellGroup& group = weights.groups[g];
  const auto* terms = &terms_[group.first - stresses_.first()];
  const int num_nodes = group.num_nodes;
  sums.start(num_nodes);
  for (std::int32_t e = group.first; e < group.last; ++e) {
    sums.add_forces(weights, e, terms[e - group.first]);
  }
  constexpr int most = max_group_nodes<dim> * dim;
  double left[most], gradient[most], right[most];
  sums.fields.take(num_nodes, Batch::left, left);
  sums.fields.take(num_nodes, Batch::volume, gradient);
  sums.fields.take(num_nodes, Batch::right, right);
  const GroupSums& of_group = sums_[group_of_[group.first - stresses_.first()]];
  const double rest = of_group.coupling - of_group.pressure;
  for (int i = 0; i < num_nodes * dim; ++i) right[i] += rest * gradient[i];
  sums.K.start(num_nodes, K.cell_blocks(g));
  sums.K.add({.left = left, .g = gradient, .right = right});
  for (std::int32_t e = group.first; e < group.last; ++e) {
    sums.add_stiffness(weights, e, terms[e - group.first]);
  }
  sums.K.finish();
}

template <int dim>
template <int n>
bool AveragedForces<dim>::evaluate_range(const Body<dim>& body, const GroupRange& range,
                                         const Target& target) {
  const bool with_K = target.K != nullptr;
  if (!find_volumes<n>(range, target.du, target.worst)) return false;
  const bool admissible = std::visit(
      [&](const auto& law) { return find_stresses(law, with_K, target.worst); }, body.material.law);
  if (!admissible) return false;
  if (with_K) {
    add_all<n>(range, *target.K, target.f);
  } else {
    add_forces<n>(range, target.f);
  }
  return true;
}

template <int dim>
bool AveragedForces<dim>::evaluate(const GroupRange& range, const Target& target) {
  const auto& weights = parts_.weights;
  require(!weights.constant_gradient, "mpm_solver: F-bar needs gradients of each point");
  const Body<dim>& body = parts_.bodies[weights.groups[range.first].body];
  return weights.whole_cells ? evaluate_range<num_brick_nodes<dim>>(body, range, target)
                             : evaluate_range<0>(body, range, target);
}

template <int dim>
bool AveragedForces<dim>::evaluate(const Target& target) {
  return for_each_range(
      parts_, [&](const Body<dim>&, const GroupRange& range) { return evaluate(range, target); });
}

template <int dim>
std::vector<double> AveragedForces<dim>::find_start_forces(std::size_t num_values) {
  std::vector<double> f(num_values, 0.0);
  for_each_range(parts_, [&](const Body<dim>&, const GroupRange& range) {
    start(range);
    for (std::size_t b = 0; b < averages_.size(); ++b) {
      PointBatch<dim>& batch = stresses_.batches()[b];
      for (int l = 0; l < batch_size; ++l) {
        const std::int32_t p = parts_.weights.point[stresses_.entry(b, l)];
        batch.set_gradient(l, Matrix<dim>::Zero());
        batch.set_stress(l, in_plane<dim>(parts_.points.tau[p]));
      }
    }
    set_volumes();
    for (std::size_t b = 0; b < averages_.size(); ++b) {
      averages_[b].average(Lanes{}, stresses_.batches()[b].H);
    }
    sum_pressures(false);
    with_num_nodes(parts_.weights, [&]<int n>() { add_forces<n>(range, f); });
    return true;
  });
  return f;
}

template class AveragedForces<2>;
template class AveragedForces<3>;

}  // namespace gabion::mpm
