// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <array>
#include <span>
#include <vector>

#include "common/base/require.hpp"
#include "common/mechanics/materials/point_batch.hpp"
#include "common/mechanics/tensor_functions.hpp"
#include "mpm_solver/stress/point_gradient.hpp"
#include "mpm_solver/stress/stress_parts.hpp"
#include "mpm_solver/stress/undrained.hpp"

namespace gabion::mpm {

/// Groups whose points are evaluated in one go: enough to fill batches, few enough for the cache.
template <int dim>
inline constexpr std::int32_t groups_at_once = dim == 2 ? 16 : 4;

/// Visit all groups, body by body, in ranges whose points are evaluated in one go.
/// @param visit  of body and range; false ends it
/// @returns whether all were visited
template <int dim, class Visit>
bool for_each_range(const StressParts<dim>& parts, const Visit& visit) {
  const auto& body_groups = parts.weights.body_groups;
  for (std::int32_t b = 0; b < parts.points.num_bodies(); ++b) {
    for (GroupRange range{body_groups[b], 0}; range.first < body_groups[b + 1];
         range.first = range.last) {
      range.last = std::min(range.first + groups_at_once<dim>, body_groups[b + 1]);
      if (!visit(parts.bodies[b], range)) return false;
    }
  }
  return true;
}

/// Stresses of the points of consecutive entries of PointWeights, in batches of four entries. The
/// last batch is filled up by its last point.
template <int dim>
class PointStresses {
 public:
  using Batch = PointBatch<dim>;

  /// @param body  that all of them belong to
  void start(std::int32_t body, std::int32_t first, std::int32_t last) {
    body_ = body;
    first_ = first;
    count_ = last - first;
    batches_.resize((count_ + Batch::size - 1) / Batch::size);
  }
  void start(const PointWeights<dim>& weights, const GroupRange& range) {
    const CellGroup& group = weights.groups[range.first];
    start(group.body, group.first, weights.groups[range.last - 1].last);
  }
  std::int32_t first() const { return first_; }
  /// Number of points of a batch.
  int points_of(std::size_t b) const {
    return std::min(Batch::size, count_ - static_cast<int>(b) * Batch::size);
  }
  /// Entry of a lane; the last one fills up.
  std::int32_t entry(std::size_t b, int l) const {
    return first_ + std::min(static_cast<int>(b) * Batch::size + l, count_ - 1);
  }
  std::span<Batch> batches() { return batches_; }

  Batch& batch_of(std::int32_t entry) {
    return batches_[static_cast<unsigned>(entry - first_) / Batch::size];
  }
  int lane_of(std::int32_t entry) const {
    return static_cast<unsigned>(entry - first_) % Batch::size;
  }
  /// Gradient of an entry, to be set before `evaluate`.
  void set_gradient(std::int32_t entry, const Matrix<dim>& H) {
    const std::int32_t k = entry - first_;
    batches_[k / Batch::size].set_gradient(k % Batch::size, H);
  }
  /// The gradients of all entries, those of the groups of a range.
  /// @tparam n  see EntryValues
  template <int n>
  void set_gradients(const StressParts<dim>& parts, const GroupRange& range,
                     std::span<const double> du) {
    NodeMotion<dim> of_group;
    for (std::int32_t g = range.first; g < range.last; ++g) {
      const CellGroup& group = parts.weights.groups[g];
      parts.nodes.gather(parts.weights.nodes_of(group), du, of_group.du);
      for (std::int32_t e = group.first; e < group.last; ++e) {
        gabion::mpm::set_gradient<n>(parts.weights, e, of_group.du, batch_of(e), lane_of(e));
      }
    }
  }
  /// Fill up the last batch, once all gradients are set.
  void fill_up() {
    const int used = count_ % Batch::size;
    if (used == 0) return;
    for (int l = used; l < Batch::size; ++l) {
      for (Lanes& x : batches_.back().H) x[l] = x[used - 1];
    }
  }
  Matrix<dim> P(std::int32_t entry) const {
    return batches_[(entry - first_) / Batch::size].stress((entry - first_) % Batch::size);
  }
  Tangent<dim> A(std::int32_t entry) const {
    return batches_[(entry - first_) / Batch::size].tangent((entry - first_) % Batch::size);
  }
  /// A number of each point of a batch; the last one fills up.
  template <class OfEntry>
  Lanes of_points(std::size_t b, const OfEntry& of_entry) const {
    Lanes x;
    for (int l = 0; l < Batch::size; ++l) x[l] = of_entry(entry(b, l));
    return x;
  }

  /// Volumes of the points of a batch, as PointWeights has them [m^3].
  Lanes V0(const StressParts<dim>& parts, std::size_t b) const {
    return of_points(b, [&](std::int32_t e) { return parts.weights.volume[e]; });
  }

  /// Set P, A if wanted, and the trial state.
  /// @param worst  set to the point that makes the state inadmissible
  /// @returns false when a law gives no stress, a point would be squeezed below min_J_ratio of its
  ///          volume, or its pores be closed
  template <class Law>
  bool evaluate(const StressParts<dim>& parts, const Law& law, bool with_A, RefusedPoint& worst) {
    fill_up();
    for (std::size_t b = 0; b < batches_.size(); ++b) {
      Batch& batch = batches_[b];
      const int n = points_of(b);
      for (int l = 0; l < Batch::size; ++l) {
        batch.state_n[l] = &state_of(parts, parts.weights.point[entry(b, l)]);
      }
      batch.out = n == Batch::size ? place(parts, entry(b, 0)) : spare_.place();
      const Law* shared = shared_law(parts, law, b);
      const int refused =
          shared ? update(parts, *shared, b, with_A) : update_each(parts, law, b, with_A);
      if (refused < n) {
        worst = {parts.weights.point[entry(b, refused)], refusal_};
        return false;
      }
      if constexpr (!Law::is_elastic) {
        if (parts.has_path()) advance<Law>(parts, batch, b);
      }
      if (n < Batch::size) spare_.copy(n, place(parts, entry(b, 0)));
    }
    const std::optional<PoreWater>& water = parts.bodies[body_].water;
    return !water || water->drains() || add_water(parts, *water, with_A, worst);
  }

 private:
  /// Room for the results of a batch that is not full.
  struct Spare {
    MaterialState<dim> state[Batch::size];
    Symmetric<dim> tau[Batch::size], plastic_increment[Batch::size];
    double J[Batch::size], energy[Batch::size];
    YieldRegion region[Batch::size];

    BatchResults<dim> place() { return {state, tau, J, energy, plastic_increment, region}; }
    void copy(int n, const BatchResults<dim>& to) const {
      std::copy_n(state, n, to.state);
      std::copy_n(tau, n, to.tau);
      std::copy_n(J, n, to.J);
      std::copy_n(energy, n, to.energy);
      std::copy_n(plastic_increment, n, to.plastic_increment);
      std::copy_n(region, n, to.region);
    }
  };

  static const MaterialState<dim>& state_of(const StressParts<dim>& parts, std::int32_t p) {
    return parts.has_path() ? parts.path->history[p] : parts.points.history[p];
  }
  /// Context of the law at an entry's point.
  template <class Law>
  PointContext context_of(const StressParts<dim>& parts, std::int32_t e) const {
    if constexpr (!ContextualLaw<Law, dim>) return {};
    if constexpr (!RemembersInternal<Law> && !HasVariables<Law>) return {.dt = parts.context->dt};
    const std::int32_t p = parts.weights.point[e];
    PointContext context = parts.context->of_point(parts.points, p);
    if constexpr (HasVariables<Law>) {
      if (parts.has_path()) context.variables = numbers_of(parts.path->variables[p]);
      context.new_variables = numbers_of(parts.trial.variables[e]);
    } else if (parts.has_path()) {
      context.internal = parts.path->internal[p];
    }
    return context;
  }
  // The next substep begins at this one's end. A state that stayed elastic is the one it was.
  template <class Law>
  void advance(const StressParts<dim>& parts, const Batch& batch, std::size_t b) const {
    for (int l = 0; l < points_of(b); ++l) {
      const std::int32_t p = parts.weights.point[entry(b, l)];
      if constexpr (HasVariables<Law>) {
        parts.path->history[p] = batch.out.state[l];
        parts.path->variables[p] = parts.trial.variables[entry(b, l)];
        parts.path->F[p] = Matrix<dim>::Identity() + batch.gradient(l);
        continue;
      }
      MaterialState<dim>& state = parts.path->history[p];
      if (batch.out.region[l] == YieldRegion::elastic && state.gap == 0) continue;
      state = batch.out.state[l];
      state.e = pull_back<dim>(batch.gradient(l), state.e);
      if (!parts.trial.internal.empty())
        parts.path->internal[p] = parts.trial.internal[entry(b, l)];
    }
  }
  // Add the stress of the pore water, in all batches.
  bool add_water(const StressParts<dim>& parts, const PoreWater& water, bool with_A,
                 RefusedPoint& worst) {
    TrialPoints<dim>& trial = parts.trial;
    trial.pore_tau.resize(trial.tau.size(), 0.0);
    for (std::size_t b = 0; b < batches_.size(); ++b) {
      PoreStress stress;
      for (int l = 0; l < Batch::size; ++l) {
        const std::int32_t e = entry(b, l), p = parts.weights.point[e];
        if (!parts.points.is_wet(p)) continue;
        const double J = parts.points.J[p] * trial.J_ratio[e];
        if (!water.admits(J)) {
          worst = {p, Refusal::pores_closed};
          return false;
        }
        const PorePressure pore = water.at(parts.points.water[p], J);
        stress.Jp[l] = J * pore.p;
        stress.Jq[l] = J * pore.stiffness;
        if (l >= points_of(b)) continue;
        trial.tau[e].template head<3>().array() -= J * pore.p;
        trial.energy[e] += pore.energy;
        trial.pore_tau[e] = J * pore.p;
      }
      add_pore_stress<dim>(stress, with_A, batches_[b]);
    }
    return true;
  }
  static BatchResults<dim> place(const StressParts<dim>& parts, std::int32_t entry) {
    TrialPoints<dim>& trial = parts.trial;
    return {trial.history.data() + entry,           trial.tau.data() + entry,
            trial.J_ratio.data() + entry,           trial.energy.data() + entry,
            trial.plastic_increment.data() + entry, trial.region.data() + entry};
  }

  // @returns the number in the batch of a point that makes the state inadmissible, or the number of
  //          points
  template <class Law>
  int update(const StressParts<dim>& parts, const Law& law, std::size_t b, bool with_A) {
    Batch& batch = batches_[b];
    const int n = points_of(b);
    refusal_ = Refusal::squeezed;
    if constexpr (requires { law.batch_return()->update(batch, with_A); }) {
      if (law.batch_return() && law.batch_return()->update(batch, with_A)) {
        if (!any(load_lanes(batch.out.J) < min_J_ratio)) return n;
        return static_cast<int>(
            std::find_if(batch.out.J, batch.out.J + n, [](double J) { return J < min_J_ratio; }) -
            batch.out.J);
      }
    }
    if constexpr (ContextualLaw<Law, dim>) {
      require(parts.context != nullptr, "mpm_solver: a law that depends on the step without one");
    }
    return update_lanes(parts, law, b, with_A);
  }

  /// State in which the increment of a point begins.
  struct PointStart {
    const MaterialState<dim>& state;
    const Matrix<dim>* F;  // of the step up to there, for laws with state variables; null: 1
  };
  static PointStart start_of(const StressParts<dim>& parts, std::int32_t e) {
    const std::int32_t p = parts.weights.point[e];
    const bool has_F = parts.has_path() && !parts.path->F.empty();
    return {state_of(parts, p), has_F ? &parts.path->F[p] : nullptr};
  }
  // The law of a point. A law with state variables sees the increment since the last substep.
  template <class Law>
  static bool update_point(const LawInStep<Law, dim>& law, const PointStart& from,
                           const Matrix<dim>& H, StressUpdate<dim>& found, Tangent<dim>* A) {
    if constexpr (HasVariables<Law>) {
      if (from.F != nullptr) {
        require(A == nullptr, "mpm_solver: a tangent in a substep");
        const Matrix<dim> inverse = from.F->inverse();
        const Matrix<dim> increment = (Matrix<dim>::Identity() + H - *from.F) * inverse;
        if (!law.update(increment, from.state, found, A)) return false;
        found.P = (found.P * inverse.transpose()).eval();
        found.J *= from.F->determinant();
        return true;
      }
    }
    return law.update(H, from.state, found, A);
  }

  // The law that all points of a batch have, null: their constants differ.
  template <class Law>
  const Law* shared_law(const StressParts<dim>& parts, const Law& own, std::size_t b) const {
    if (parts.laws.empty()) return &own;
    const Law* first = &parts.law_of(parts.weights.point[entry(b, 0)], own);
    for (int l = 1; l < Batch::size; ++l) {
      if (&parts.law_of(parts.weights.point[entry(b, l)], own) != first) return nullptr;
    }
    return first;
  }

  // Update the points of a batch where each has its own law.
  template <class Law>
  int update_each(const StressParts<dim>& parts, const Law& own, std::size_t b, bool with_A) {
    Batch& batch = batches_[b];
    refusal_ = Refusal::squeezed;
    require(!ContextualLaw<Law, dim> || parts.context != nullptr,
            "mpm_solver: a law that depends on the step without one");
    StressUpdate<dim> found;
    Tangent<dim> A;
    for (int l = 0; l < points_of(b); ++l) {
      const std::int32_t e = entry(b, l);
      LawInStep<Law, dim> in_step{parts.law_of(parts.weights.point[e], own), {}};
      if constexpr (ContextualLaw<Law, dim>) in_step.context = context_of<Law>(parts, e);
      if (!update_point(in_step, start_of(parts, e), batch.gradient(l), found,
                        with_A ? &A : nullptr)) {
        refusal_ = found.refusal;
        return l;
      }
      batch.set(l, found, with_A ? &A : nullptr);
      if (batch.out.J[l] < min_J_ratio) return l;
      if constexpr (RemembersInternal<Law>) parts.trial.internal[e] = found.internal;
    }
    return points_of(b);
  }

  // Update lane by lane, except those that a law with internal variables finds elastic at once:
  // update_elastic(contexts, batch, with_A) returns which they are.
  template <class Law>
  int update_lanes(const StressParts<dim>& parts, const Law& law, std::size_t b, bool with_A) {
    Batch& batch = batches_[b];
    const int n = points_of(b);
    [[maybe_unused]] std::array<PointContext, Batch::size> contexts;
    if constexpr (ContextualLaw<Law, dim>) {
      for (int l = 0; l < Batch::size; ++l) contexts[l] = context_of<Law>(parts, entry(b, l));
    }
    LaneMask done{};
    if constexpr (requires { law.update_elastic(contexts, batch, with_A); }) {
      done = law.update_elastic(contexts, batch, with_A);
    }
    LawInStep<Law, dim> in_step{law, {}};
    StressUpdate<dim> found;
    Tangent<dim> A;
    for (int l = 0; l < n; ++l) {
      if constexpr (ContextualLaw<Law, dim>) in_step.context = contexts[l];
      if (!done[l]) {
        if (!update_point(in_step, start_of(parts, entry(b, l)), batch.gradient(l), found,
                          with_A ? &A : nullptr)) {
          refusal_ = found.refusal;
          return l;
        }
        batch.set(l, found, with_A ? &A : nullptr);
      }
      if (batch.out.J[l] < min_J_ratio) return l;
      if constexpr (RemembersInternal<Law>) {
        parts.trial.internal[entry(b, l)] = done[l] ? contexts[l].internal : found.internal;
      }
    }
    return n;
  }

  std::int32_t body_ = 0, first_ = 0;
  int count_ = 0;
  std::vector<Batch> batches_;
  Spare spare_;
  Refusal refusal_ = Refusal::squeezed;  // of the last update that did not return all points
};

}  // namespace gabion::mpm
