// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/step/explicit_reach.hpp"

#include <algorithm>
#include <cstring>
#include <utility>

#include "mpm_solver/stress/point_stresses.hpp"

namespace gabion::mpm {

namespace {

// Share of the points within reach, mean over the substeps; a larger reach is not worth its
// bookkeeping.
constexpr double most_of_the_soil = 0.8;

}  // namespace

template <int dim>
ExplicitReach<dim>::ExplicitReach(const StressParts<dim>& parts) : parts_(parts) {}

template <int dim>
void ExplicitReach<dim>::begin(int count) {
  group_since_.assign(parts_.weights.groups.size(), never);
  for (auto* since : {&moved_, &loaded_, &answered_}) {
    since->assign(static_cast<std::size_t>(parts_.nodes.size()), never);
  }
  substeps_.clear();
  now_ = -1;
  count_ = count;
  keeps_ = true;
  is_complete_ = false;
}

// Give the marks of a node on one rank to all ranks that hold it.
template <int dim>
void ExplicitReach<dim>::share(std::vector<char>& marks) const {
  const SharedNodes& shared = parts_.nodes.shared;
  if (shared.alone()) return;
  std::vector<double> sums(marks.begin(), marks.end());
  shared.sum(sums, 1);
  for (std::size_t i = 0; i < marks.size(); ++i) marks[i] = sums[i] > 0 ? 1 : 0;
}

template <int dim>
void ExplicitReach<dim>::share(std::vector<std::int32_t>& since) const {
  if (parts_.nodes.shared.alone()) return;
  std::vector<char> marks;
  for (const std::int32_t first : since) marks.push_back(first <= now_ ? 1 : 0);
  share(marks);
  for (std::size_t i = 0; i < since.size(); ++i) {
    if (marks[i] != 0) since[i] = std::min(since[i], now_);
  }
}

template <int dim>
bool ExplicitReach<dim>::any_since(const CellGroup& group,
                                   const std::vector<std::int32_t>& since) const {
  return std::ranges::any_of(nodes_of(group), [&](std::int32_t i) { return since[i] <= now_; });
}

// All nodes of the points that a marked node acts on.
template <int dim>
void ExplicitReach<dim>::add_points(const std::vector<char>& marks,
                                    std::vector<std::int32_t>& since) const {
  const PointWeights<dim>& weights = parts_.weights;
  for (const CellGroup& group : weights.groups) {
    const auto nodes = nodes_of(group);
    if (std::ranges::none_of(nodes, [&](std::int32_t i) { return marks[i] != 0; })) continue;
    for (std::int32_t e = group.first; e < group.last; ++e) {
      const std::uint8_t* local = weights.local_of(e);
      const std::uint8_t* const end = local + weights.num_nodes(e);
      if (std::none_of(local, end, [&](std::uint8_t i) { return marks[nodes[i]] != 0; })) continue;
      for (; local != end; ++local) since[nodes[*local]] = std::min(since[nodes[*local]], now_);
    }
  }
}

// Nodes where the force of a contact may differ: those of an interface, and of any contact with
// soil that moves differently.
template <int dim>
std::vector<char> ExplicitReach<dim>::pushed_nodes(std::span<const double> F,
                                                   std::span<const char> touched) const {
  std::vector<char> pushed(touched.begin(), touched.end());
  const auto has_force = [&](std::int32_t i) {
    const double* f = F.data() + std::ptrdiff_t{i} * dim;
    return std::any_of(f, f + dim, [](double x) { return x != 0; });
  };
  for (const CellGroup& group : parts_.weights.groups) {
    const auto nodes = nodes_of(group);
    if (!any_since(group, moved_) || std::ranges::none_of(nodes, has_force)) continue;
    for (const std::int32_t i : nodes) pushed[i] = 1;
  }
  share(pushed);
  return pushed;
}

template <int dim>
void ExplicitReach<dim>::find(std::span<const double> F, std::span<const char> touched) {
  ++now_;
  substeps_.emplace_back();
  for (std::size_t i = 0; i < moved_.size(); ++i) {
    if (answered_[i] < now_) moved_[i] = std::min(moved_[i], now_);
  }
  add_points(pushed_nodes(F, touched), moved_);
  share(moved_);
  find_evaluated();
  keeps_ = pays();
  if (!keeps_) return substeps_.clear();
  find_border();
  std::vector<char> loaded;
  for (const std::int32_t since : loaded_) loaded.push_back(since <= now_ ? 1 : 0);
  for (std::size_t i = 0; i < moved_.size(); ++i) {
    if (moved_[i] <= now_) answered_[i] = std::min(answered_[i], now_);
  }
  add_points(loaded, answered_);
  share(answered_);
}

template <int dim>
void ExplicitReach<dim>::find_evaluated() {
  const auto& groups = parts_.weights.groups;
  Substep& substep = substeps_.back();
  if (now_ > 0) substep.num_points = substeps_[now_ - 1].num_points;
  for (std::int32_t g = 0; g < std::ssize(groups); ++g) {
    if (group_since_[g] != never || !any_since(groups[g], moved_)) continue;
    group_since_[g] = now_;
    for (const std::int32_t i : nodes_of(groups[g])) loaded_[i] = std::min(loaded_[i], now_);
    substep.first_groups.push_back(g);
    substep.num_points += groups[g].last - groups[g].first;
  }
  share(loaded_);
}

template <int dim>
void ExplicitReach<dim>::find_border() {
  const auto& groups = parts_.weights.groups;
  for (std::int32_t g = 0; g < std::ssize(groups); ++g) {
    if (group_since_[g] == never && any_since(groups[g], loaded_)) {
      substeps_.back().border.push_back(g);
    }
  }
}

// Whether later solutions are small enough to pay, if D does not grow further.
template <int dim>
bool ExplicitReach<dim>::pays() const {
  double sums[] = {0, static_cast<double>(parts_.points.size())};
  for (const Substep& substep : substeps_) sums[0] += static_cast<double>(substep.num_points);
  const auto rest = static_cast<double>(count_ - std::ssize(substeps_));
  sums[0] += rest * static_cast<double>(substeps_.back().num_points);
  parts_.nodes.shared.total(sums);
  return sums[0] < most_of_the_soil * count_ * sums[1];
}

template <int dim>
void ExplicitReach<dim>::keep_states(const MaterialPath<dim>& path,
                                     std::span<const Symmetric<dim>> tau) {
  if (tau.empty()) return;
  Substep& substep = substeps_.back();
  for_each_first(substep, [&](std::int32_t p) {
    PointState& state = substep.states.emplace_back();
    state.tau = tau[p];
    if (!path.history.empty()) state.history = path.history[p];
    if (!path.internal.empty()) state.internal = path.internal[p];
  });
}

template <int dim>
void ExplicitReach<dim>::load_states(int k, MaterialPath<dim>& path,
                                     std::span<Symmetric<dim>> tau) const {
  if (tau.empty()) return;
  const Substep& substep = substeps_[k];
  auto state = substep.states.begin();
  for_each_first(substep, [&](std::int32_t p) {
    tau[p] = state->tau;
    if (!path.history.empty()) path.history[p] = state->history;
    if (!path.internal.empty()) path.internal[p] = state->internal;
    ++state;
  });
}

template <int dim>
void ExplicitReach<dim>::ask_for_forces(GroupForces<dim>& kept) const {
  const auto& groups = parts_.weights.groups;
  kept.place.assign(groups.size(), -1);
  std::int32_t size = 0;
  for (const std::int32_t g : substeps_.back().border) {
    kept.place[g] = size;
    size += groups[g].num_nodes * dim;
  }
  kept.values.resize(static_cast<std::size_t>(size));
}

template <int dim>
void ExplicitReach<dim>::keep(Fields fields, std::vector<double> group_forces) {
  substeps_.back().fields = std::move(fields);
  substeps_.back().border_forces = std::move(group_forces);
}

template <int dim>
bool ExplicitReach<dim>::covers(int k, std::span<const double> du) const {
  const std::vector<double>& known = substeps_[k].fields.du;
  for (std::size_t i = 0; i < moved_.size(); ++i) {
    if (moved_[i] <= k) continue;
    if (std::memcmp(&du[i * dim], &known[i * dim], dim * sizeof(double)) != 0) return false;
  }
  return true;
}

template <int dim>
ForcePart ExplicitReach<dim>::part(int k) {
  const auto& groups = parts_.weights.groups;
  ranges_.clear();
  for (std::int32_t g = 0; g < std::ssize(groups); ++g) {
    if (group_since_[g] > k) continue;
    const bool extends = !ranges_.empty() && ranges_.back().last == g &&
                         g - ranges_.back().first < groups_at_once<dim> &&
                         groups[g - 1].body == groups[g].body;
    if (extends) {
      ranges_.back().last = g + 1;
    } else {
      ranges_.push_back({g, g + 1});
    }
  }
  return {
      .ranges = ranges_, .known = substeps_[k].border, .known_forces = substeps_[k].border_forces};
}

template <int dim>
std::vector<std::int32_t> ExplicitReach<dim>::responding_groups(int k) const {
  std::vector<std::int32_t> list;
  const auto& groups = parts_.weights.groups;
  for (std::int32_t g = 0; g < std::ssize(groups); ++g) {
    const auto answers = [&](std::int32_t i) { return answered_[i] <= k; };
    if (std::ranges::any_of(nodes_of(groups[g]), answers)) list.push_back(g);
  }
  return list;
}

template <int dim>
void ExplicitReach<dim>::replace(const std::vector<std::int32_t>& since, int k,
                                 std::span<const double> known, std::span<double> field) const {
  for (std::size_t i = 0; i < since.size(); ++i) {
    if (since[i] > k) std::copy_n(known.data() + i * dim, dim, field.data() + i * dim);
  }
}

template <int dim>
void ExplicitReach<dim>::fill_internal(int k, std::span<double> internal) const {
  replace(loaded_, k, substeps_[k].fields.internal, internal);
}

template <int dim>
void ExplicitReach<dim>::fill_A(int k, std::span<double> A) const {
  replace(answered_, k, substeps_[k].fields.A, A);
}

template class ExplicitReach<2>;
template class ExplicitReach<3>;

}  // namespace gabion::mpm
