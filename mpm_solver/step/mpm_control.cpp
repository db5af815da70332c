// SPDX-License-Identifier: BSD-3-Clause
// How MpmSolver judges its steps: iterations, failures, the size of the next one.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <limits>

#include "common/base/log.hpp"
#include "common/base/require.hpp"
#include "common/mechanics/ranks/sum.hpp"
#include "common/mechanics/ranks/text.hpp"
#include "mpm_solver/mpm_solver.hpp"
#include "mpm_solver/stress/point_motion.hpp"

namespace gabion::mpm {

template <int dim>
StepReport MpmSolver<dim>::solve_step(const StepRequest& request, const InterfaceValues& received,
                                      InterfaceValues& sent) {
  try {
    return try_step(request, received, sent);
  } catch (const ConvergenceError& error) {
    newton_counts_.add_failure(error.cause());
    if (error.cause() != phase_cause) control_.fail(request.dt);
    throw;
  }
}

template <int dim>
void MpmSolver<dim>::reject_step() {
  dt_ = 0;
  step_newton_ = 0;
  proposal_.limit = DtLimit::failure;
}

template <int dim>
void MpmSolver<dim>::refuse_exits() const {
  const auto exit = exits_.first(points_, weights_, nodes_, std::span<const double>(du_));
  std::string own;
  if (exit.point >= 0) {
    const Vector<dim>& v = points_.v[exit.point];
    const Vector<dim>& x_n = points_.x[exit.point];
    const std::string group = exits_.nearest_group(exit.x);
    const auto wall = std::find_if(phase().walls.begin(), phase().walls.end(),
                                   [&](const auto& w) { return w.group == group; });
    const std::string condition = wall == phase().walls.end() ? "no wall"
                                  : wall->fixed               ? "fixed wall"
                                                              : "slip wall";
    const std::string side =
        group.empty() ? "a side without a name" : fmt::format("side \"{}\" ({})", group, condition);
    own = fmt::format(
        "material point {} would leave the background grid through {}, from ({:.6g}) to ({:.6g}) "
        "with velocity ({:.4g}); make the grid larger, close the side with a wall, or set "
        "\"outside\": \"remove\"",
        points_.id[exit.point], side, fmt::join(x_n.data(), x_n.data() + dim, ", "),
        fmt::join(exit.x.data(), exit.x.data() + dim, ", "),
        fmt::join(v.data(), v.data() + dim, ", "));
  }
  const std::string text = first_text(comm_, own);
  if (!text.empty()) throw ConvergenceError(text, "outside");
}

template <int dim>
void MpmSolver<dim>::remove_outside(std::span<const std::int32_t> outside) {
  auto count = static_cast<std::int32_t>(outside.size());
  sum_over_ranks(comm_, std::span<std::int32_t>(&count, 1));
  if (count == 0) return;
  require(settings_.outside == Outside::remove, "mpm_solver: a point left the grid unseen");
  std::string lost;
  for (std::size_t k = 0; k < probe_points_.size(); ++k) {
    if (std::binary_search(outside.begin(), outside.end(), probe_points_[k])) {
      lost = fmt::format("material point {} of probe \"{}\" has left the background grid",
                         points_.id[probe_points_[k]], settings_.probes[k].name);
    }
    probe_points_[k] -= static_cast<std::int32_t>(
        std::lower_bound(outside.begin(), outside.end(), probe_points_[k]) - outside.begin());
  }
  remove_points(outside, points_);
  ledger_.remove(points_);
  if (removed_points_ == 0) log::warn("material points leave the background grid and are removed");
  removed_points_ += count;
  lost = first_text(comm_, lost);
  require(lost.empty(), lost);
  require(ledger_.totals().mass > 0, "all material points have left the background grid");
}

template <int dim>
StepMeasures MpmSolver<dim>::measure_step() const {
  const StepControlSettings& limits = control_.settings();
  const std::span<const double> du(du_);
  StepMeasures step;
  step.dt = dt_;
  step.newton_iterations = step_newton_;
  if (limits.advective) {
    const double largest = max_over_ranks(comm_, largest_displacement(weights_, nodes_, du));
    step.travel = largest / cell_size_;
  }
  if (limits.strain) {
    step.strain = max_over_ranks(comm_, most_strained(weights_, nodes_, du).strain);
  }
  if (limits.approach && !boundaries_.empty()) {
    // The first rank has the contact.
    double dt = std::numeric_limits<double>::infinity();
    for (const auto& boundary : boundaries_) {
      dt = std::min(dt, boundary.approach_step(dt_, *limits.approach * cell_size_));
    }
    if (rank_of(comm_) != 0) dt = std::numeric_limits<double>::infinity();
    step.approach_dt = -max_over_ranks(comm_, -dt);
  }
  return step;
}

template <int dim>
void MpmSolver<dim>::propose_dt(double time) {
  const double phase_dt = largest_step(settings_.phases[phase_at(settings_.phases, time)], time);
  proposal_ = control_.accept(measure_step(), phase_dt);
  accepted_dt_ = dt_;
  step_newton_ = 0;
}

// Tells that dt shrinks where the reason is not that of the last time.
template <int dim>
void MpmSolver<dim>::log_new_dt(const StepRequest& request) {
  if (!control_.settings().any() || accepted_dt_ == 0 || request.dt >= accepted_dt_) return;
  if (proposal_.limit == logged_limit_) return;
  logged_limit_ = proposal_.limit;
  log::info("{:.6g} s: dt from {:.4g} to {:.4g} s, limited by {}", request.time, accepted_dt_,
            request.dt, limit_name(proposal_.limit));
}

template StepReport MpmSolver<2>::solve_step(const StepRequest&, const InterfaceValues&,
                                             InterfaceValues&);
template StepReport MpmSolver<3>::solve_step(const StepRequest&, const InterfaceValues&,
                                             InterfaceValues&);
template void MpmSolver<2>::reject_step();
template void MpmSolver<3>::reject_step();
template void MpmSolver<2>::refuse_exits() const;
template void MpmSolver<3>::refuse_exits() const;
template void MpmSolver<2>::remove_outside(std::span<const std::int32_t> outside);
template void MpmSolver<3>::remove_outside(std::span<const std::int32_t> outside);
template StepMeasures MpmSolver<2>::measure_step() const;
template StepMeasures MpmSolver<3>::measure_step() const;
template void MpmSolver<2>::propose_dt(double time);
template void MpmSolver<3>::propose_dt(double time);
template void MpmSolver<2>::log_new_dt(const StepRequest& request);
template void MpmSolver<3>::log_new_dt(const StepRequest& request);

}  // namespace gabion::mpm
