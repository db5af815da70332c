// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/stress/averaged_forces.hpp"

#include <algorithm>
#include <variant>

#include "common/mechanics/ranks/sum.hpp"
#include "common/mechanics/tensor_functions.hpp"

namespace gabion::mpm {

template <int dim>
AveragedForces<dim>::AveragedForces(MPI_Comm comm, const StressParts<dim>& parts)
    : comm_(comm), parts_(parts) {
  for (std::size_t g = 0; g < parts_.weights.shared.size(); ++g) {
    if (parts_.weights.shared[g] >= 0) shared_.push_back(static_cast<std::int32_t>(g));
  }
  shared_groups_.resize(shared_.size());
}

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
bool AveragedForces<dim>::private_groups(const Law& law, std::int32_t first, std::int32_t last,
                                         const Target& target) {
  const auto& weights = parts_.weights;
  const bool with_K = target.K != nullptr;
  const std::span averages(own_.data(), last - first);
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
bool AveragedForces<dim>::private_forces(const Target& target) {
  const auto& weights = parts_.weights;
  const auto is_private = [&](std::int32_t g) {
    return weights.shared.empty() || weights.shared[g] < 0;
  };
  own_.resize(groups_at_once);
  for (std::int32_t b = 0; b < parts_.points.num_bodies(); ++b) {
    const std::int32_t end = weights.body_groups[b + 1];
    for (std::int32_t first = weights.body_groups[b]; first < end;) {
      std::int32_t last = first;
      while (last < end && last - first < groups_at_once && is_private(last)) ++last;
      const bool admissible =
          last == first ||
          std::visit([&](const auto& law) { return private_groups(law, first, last, target); },
                     parts_.bodies[b].material.law);
      if (!admissible) return false;
      first = std::max(last, first + 1);
    }
  }
  return true;
}

// Sum the groups' volumes over the ranks. Returns false when a rank's state is inadmissible.
template <int dim>
bool AveragedForces<dim>::share_volumes(bool admissible) {
  sums_.assign(2 * static_cast<std::size_t>(parts_.weights.num_shared) + 1, 0);
  sums_.back() = admissible ? 0 : 1;
  for (std::size_t s = 0; s < shared_.size(); ++s) {
    double* sums = sums_.data() + 2 * static_cast<std::size_t>(parts_.weights.shared[shared_[s]]);
    sums[0] = shared_groups_[s].volumes.before;
    sums[1] = shared_groups_[s].volumes.change;
  }
  sum_over_ranks(comm_, std::span<double>(sums_));
  for (std::size_t s = 0; s < shared_.size(); ++s) {
    const double* sums =
        sums_.data() + 2 * static_cast<std::size_t>(parts_.weights.shared[shared_[s]]);
    shared_groups_[s].volumes = {sums[0], sums[1]};
  }
  return sums_.back() == 0;
}

// Sum the groups' pressures and volume gradients over the ranks; leaves the latter in sums_.
template <int dim>
bool AveragedForces<dim>::share_pressures(bool admissible, bool with_K) {
  const auto& weights = parts_.weights;
  const std::size_t width = 1 + (with_K ? CellForces<dim>::max_dofs : 0);
  sums_.assign(width * weights.num_shared + 1, 0);
  sums_.back() = admissible ? 0 : 1;
  for (std::size_t s = 0; s < shared_.size(); ++s) {
    double* sums = sums_.data() + width * weights.shared[shared_[s]];
    sums[0] = shared_groups_[s].pressure;
    if (with_K) {
      shared_groups_[s].add_volume_gradient(weights, weights.groups[shared_[s]], sums + 1);
    }
  }
  sum_over_ranks(comm_, std::span<double>(sums_));
  for (std::size_t s = 0; s < shared_.size(); ++s) {
    shared_groups_[s].pressure = sums_[width * weights.shared[shared_[s]]];
  }
  return sums_.back() == 0;
}

template <int dim>
bool AveragedForces<dim>::shared_forces(std::span<const double> du, BlockMatrix<dim>* K,
                                        std::span<double> f, std::int32_t& worst) {
  const auto& weights = parts_.weights;
  bool admissible = true;
  for (std::size_t s = 0; admissible && s < shared_.size(); ++s) {
    admissible = add_points(shared_[s], du, shared_groups_[s], worst);
  }
  if (!share_volumes(admissible)) return false;
  for (std::size_t s = 0; admissible && s < shared_.size(); ++s) {
    admissible = std::visit(
        [&](const auto& law) {
          return add_stresses(law, shared_[s], K != nullptr, std::span(&shared_groups_[s], 1),
                              worst);
        },
        parts_.bodies[weights.groups[shared_[s]].body].material.law);
  }
  if (!share_pressures(admissible, K != nullptr)) return false;
  for (std::size_t s = 0; s < shared_.size(); ++s) {
    const std::size_t width = 1 + CellForces<dim>::max_dofs;
    const double* gradient = K ? sums_.data() + width * weights.shared[shared_[s]] + 1 : nullptr;
    add_forces(shared_[s], gradient, shared_groups_[s], K, f);
  }
  return true;
}

template <int dim>
bool AveragedForces<dim>::evaluate(std::span<const double> du, BlockMatrix<dim>* K,
                                   std::span<double> f, std::int32_t& worst) {
  const bool shared = parts_.weights.num_shared == 0 || shared_forces(du, K, f, worst);
  return shared && private_forces({.du = du, .K = K, .f = f, .worst = worst});
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
void AveragedForces<dim>::add_start_forces(std::span<double> f) {
  const auto& weights = parts_.weights;
  own_.resize(1);
  for (std::size_t g = 0; g < weights.groups.size(); ++g) {
    if (!weights.shared.empty() && weights.shared[g] >= 0) continue;
    add_accepted_stresses(static_cast<std::int32_t>(g), own_[0]);
    add_forces(static_cast<std::int32_t>(g), nullptr, own_[0], nullptr, f);
  }
  if (weights.num_shared == 0) return;
  for (std::size_t s = 0; s < shared_.size(); ++s) {
    add_accepted_stresses(shared_[s], shared_groups_[s]);
  }
  share_volumes(true);
  share_pressures(true, false);
  for (std::size_t s = 0; s < shared_.size(); ++s) {
    add_forces(shared_[s], nullptr, shared_groups_[s], nullptr, f);
  }
}

template <int dim>
std::vector<double> AveragedForces<dim>::start_forces(std::size_t num_values) const {
  std::vector<double> f(num_values, 0.0);
  AveragedForces(comm_, parts_).add_start_forces(f);
  return f;
}

template class AveragedForces<2>;
template class AveragedForces<3>;

}  // namespace gabion::mpm
