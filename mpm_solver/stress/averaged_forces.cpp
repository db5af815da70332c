// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/stress/averaged_forces.hpp"

#include <algorithm>
#include <variant>

#include "common/mechanics/tensor_functions.hpp"

namespace gabion::mpm {

template <int dim>
bool AveragedForces<dim>::add_points(std::int32_t g, std::span<const double> du,
                                     AveragedGroup<dim>& average, std::int32_t& worst) const {
  const auto& [bodies, points, weights, nodes, trial] = parts_;
  const CellGroup& group = weights.groups[g];
  GroupDisplacements<dim> of_group;
  nodes.gather(weights.nodes_of(group), du, of_group.data());
  average.start();
  for (std::int32_t e = group.first; e < group.last; ++e) {
    const std::int32_t p = weights.point[e];
    const double V = points.V0[p] * points.J[p];
    const Matrix<dim> H = displacement_gradient(weights, e, of_group.data());
    if (average.add_point(H, V) >= min_J_ratio) continue;
    worst = p;
    return false;
  }
  return true;
}

// Of the consecutive groups from g on.
template <int dim>
template <class Law>
bool AveragedForces<dim>::add_stresses(const Law& law, std::int32_t g, bool with_K,
                                       std::span<AveragedGroup<dim>> averages,
                                       std::int32_t& worst) {
  const auto* groups = parts_.weights.groups.data() + g;
  stresses_.start(groups[0].first, groups[averages.size() - 1].last);
  for (std::size_t k = 0; k < averages.size(); ++k) {
    for (std::int32_t e = groups[k].first; e < groups[k].last; ++e) {
      stresses_.H(e) = averages[k].averaged_gradient(e - groups[k].first);
    }
  }
  if (!stresses_.evaluate(parts_, law, with_K, worst)) return false;
  for (std::size_t k = 0; k < averages.size(); ++k) {
    for (std::int32_t e = groups[k].first; e < groups[k].last; ++e) {
      averages[k].set_stress(e - groups[k].first, parts_.points.V0[parts_.weights.point[e]],
                             stresses_.P(e), with_K ? &stresses_.A(e) : nullptr);
    }
  }
  return true;
}

template <int dim>
void AveragedForces<dim>::add_forces(std::int32_t g, const double* gradient,
                                     AveragedGroup<dim>& average, BlockMatrix<dim>* K,
                                     std::span<double> f) const {
  const CellGroup& group = parts_.weights.groups[g];
  std::int32_t active[max_group_nodes<dim>];
  parts_.nodes.list_active(parts_.weights.nodes_of(group), active);
  CellForces<dim> sum;
  sum.set_zero(group.num_nodes, false);
  average.add_forces(parts_.weights, group, gradient, sum);
  sum.scatter(group.num_nodes, active, f.data());
  if (K) K->add_cell_blocks(g, sum.K);
}

template <int dim>
template <class Law>
bool AveragedForces<dim>::group_forces(const Law& law, std::int32_t first, std::int32_t last,
                                       const Target& target) {
  const auto& weights = parts_.weights;
  const bool with_K = target.K != nullptr;
  const std::span averages(averages_.data(), last - first);
  for (std::int32_t g = first; g < last; ++g) {
    if (!add_points(g, target.du, averages[g - first], target.worst)) return false;
  }
  if (!add_stresses(law, first, with_K, averages, target.worst)) return false;
  double gradient[CellForces<dim>::max_dofs];
  for (std::int32_t g = first; g < last; ++g) {
    if (with_K) {
      std::fill_n(gradient, weights.groups[g].num_nodes * dim, 0.0);
      averages[g - first].add_volume_gradient(weights, weights.groups[g], gradient);
    }
    add_forces(g, with_K ? gradient : nullptr, averages[g - first], target.K, target.f);
  }
  return true;
}

template <int dim>
bool AveragedForces<dim>::evaluate(const Target& target) {
  const auto& weights = parts_.weights;
  averages_.resize(groups_at_once);
  for (std::int32_t b = 0; b < parts_.points.num_bodies(); ++b) {
    const std::int32_t end = weights.body_groups[b + 1];
    for (std::int32_t first = weights.body_groups[b], last = first; first < end; first = last) {
      last = std::min(first + groups_at_once, end);
      const bool admissible =
          std::visit([&](const auto& law) { return group_forces(law, first, last, target); },
                     parts_.bodies[b].material.law);
      if (!admissible) return false;
    }
  }
  return true;
}

template <int dim>
void AveragedForces<dim>::add_accepted_stresses(std::int32_t g, AveragedGroup<dim>& average) const {
  const auto& points = parts_.points;
  const CellGroup& group = parts_.weights.groups[g];
  average.start();
  for (std::int32_t e = group.first; e < group.last; ++e) {
    const std::int32_t p = parts_.weights.point[e];
    average.add_point(Matrix<dim>::Zero(), points.V0[p] * points.J[p]);
    average.set_stress(e - group.first, points.V0[p], in_plane<dim>(points.tau[p]), nullptr);
  }
}

template <int dim>
std::vector<double> AveragedForces<dim>::start_forces(std::size_t num_values) const {
  std::vector<double> f(num_values, 0.0);
  AveragedGroup<dim> average;
  for (std::size_t g = 0; g < parts_.weights.groups.size(); ++g) {
    add_accepted_stresses(static_cast<std::int32_t>(g), average);
    add_forces(static_cast<std::int32_t>(g), nullptr, average, nullptr, f);
  }
  return f;
}

template class AveragedForces<2>;
template class AveragedForces<3>;

}  // namespace gabion::mpm
