// SPDX-License-Identifier: BSD-3-Clause
// What MpmSolver tells: log, probes, frames, sums.
#include <fmt/format.h>

#include <limits>

#include "common/base/log.hpp"
#include "common/mechanics/ranks/sum.hpp"
#include "mpm_solver/mpm_solver.hpp"

namespace gabion::mpm {

template <int dim>
void MpmSolver<dim>::log_grid() const {
  log::info(
      "background grid: {} cells, {} nodes, mean size {:.4g} m; elastic wave speed {:.4g} m/s",
      grid_.mesh.num_cells(), grid_.mesh.num_nodes_total(), cell_size_, wave_speed_);
  std::vector<double> counts = {static_cast<double>(points_.size()),
                                static_cast<double>(weights_.N.size())};
  sum_over_ranks(comm_, std::span<double>(counts));
  log::info("basis: {}, {:.3g} nodes a point", basis_name(grid_.basis), counts[1] / counts[0]);
}

template <int dim>
void MpmSolver<dim>::find_probe_points() {
  for (const auto& probe : settings_.probes) {
    std::int32_t nearest = -1;
    double distance = std::numeric_limits<double>::infinity();
    for (std::int32_t p = 0; p < points_.size(); ++p) {
      const double d = (points_.x[p] - probe.point).norm();
      if (d < distance) {
        distance = d;
        nearest = p;
      }
    }
    const double least = -max_over_ranks(comm_, -distance);
    if (least > cell_size_) {
      log::warn(
          "mpm.json: at /probes/{}/point: the material point nearest to probe \"{}\" is {:.3g} m "
          "away, more than a cell of the grid ({:.3g} m)",
          probe_points_.size(), probe.name, least, cell_size_);
    }
    const double id = distance == least ? static_cast<double>(points_.id[nearest])
                                        : std::numeric_limits<double>::infinity();
    const bool owner = nearest >= 0 && id == -max_over_ranks(comm_, -id);
    probe_points_.push_back(owner ? nearest : -1);
  }
}

template <int dim>
Json MpmSolver<dim>::accepted_details(std::span<const std::int32_t> cell_n) const {
  double smallest = std::numeric_limits<double>::infinity();
  for (const double J_ratio : trial_.J_ratio) smallest = std::min(smallest, J_ratio);
  std::int32_t moved = 0;
  for (std::size_t p = 0; p < cell_n.size(); ++p) moved += points_.cell[p] != cell_n[p];
  sum_over_ranks(comm_, std::span<std::int32_t>(&moved, 1));
  return {{"min_J_ratio", -max_over_ranks(comm_, -smallest)},
          {"active_nodes", nodes_.size()},
          {"points_changed_cell", moved},
          {"dt_limit", static_cast<int>(proposal_.limit)}};
}

template <int dim>
void MpmSolver<dim>::report_contact(StepReport& report, InterfaceValues& sent) const {
  report.interface_active = false;
  int closed = 0, sliding = 0;
  double penetration = 0;
  const std::size_t num_interfaces = settings_.interfaces.size();
  for (std::size_t k = 0; k < num_interfaces; ++k) {
    const auto& boundary = boundaries_[k];
    sent[boundary.name()] = boundary.forces_on_structure();
    report.interface_active |= boundary.can_touch();
    closed += boundary.num_closed();
    sliding += boundary.num_sliding();
    penetration = std::max(penetration, boundary.max_penetration());
  }
  if (num_interfaces > 0) {
    report.details = {
        {"closed_points", closed}, {"sliding_points", sliding}, {"max_penetration", penetration}};
  }
  for (std::size_t k = num_interfaces; k < boundaries_.size(); ++k) {
    const auto& wall = boundaries_[k];
    report.details[wall.name() + ".closed_points"] = wall.num_closed();
    report.details[wall.name() + ".sliding_points"] = wall.num_sliding();
    report.details[wall.name() + ".max_penetration"] = wall.max_penetration();
  }
}

template <int dim>
void MpmSolver<dim>::write_output(double time) {
  const ScopedTimer timer(times_, "output");
  output_.write(time, points_);
}

template <int dim>
std::vector<std::string> MpmSolver<dim>::probe_names() const {
  static constexpr const char* axes[] = {"x", "y", "z"};
  std::vector<std::string> names = {"mass", "kinetic_energy", "elastic_energy"};
  for (int d = 0; d < dim; ++d) names.push_back(fmt::format("momentum_{}", axes[d]));
  for (const auto& body : settings_.bodies) {
    names.push_back(settings_.bodies.size() == 1 ? "front" : "front_" + body.name);
  }
  for (const auto& name : Ledger<dim>::names()) names.push_back(name);
  for (const auto& probe : settings_.probes) {
    for (int d = 0; d < dim; ++d) names.push_back(fmt::format("{}.u{}", probe.name, axes[d]));
  }
  for (const auto& group : wall_groups_) {
    for (int d = 0; d < dim; ++d) names.push_back(fmt::format("wall.{}.f{}", group, axes[d]));
  }
  for (const auto& wall : settings_.rigid_walls) {
    for (int d = 0; d < dim; ++d) names.push_back(fmt::format("{}.f{}", wall.name, axes[d]));
    for (int d = dim == 2 ? 2 : 0; d < 3; ++d) {
      names.push_back(fmt::format("{}.m{}", wall.name, axes[d]));
    }
  }
  if (settings_.outside == Outside::remove) {
    names.insert(names.end(), {"removed_points", "removed_mass"});
  }
  return names;
}

template <int dim>
std::vector<double> MpmSolver<dim>::probes() const {
  const PointTotals<dim>& totals = ledger_.totals();
  std::vector<double> values = {totals.mass, totals.kinetic_energy, totals.elastic_energy};
  values.insert(values.end(), totals.momentum.data(), totals.momentum.data() + dim);
  values.insert(values.end(), totals.front.begin(), totals.front.end());
  const auto balance = ledger_.values();
  values.insert(values.end(), balance.begin(), balance.end());
  std::vector<double> motion;
  for (const std::int32_t p : probe_points_) {
    for (int d = 0; d < dim; ++d) motion.push_back(p < 0 ? 0.0 : points_.u[p][d]);
  }
  sum_over_ranks(comm_, std::span<double>(motion));
  values.insert(values.end(), motion.begin(), motion.end());
  for (const auto& force : wall_forces_) {
    values.insert(values.end(), force.data(), force.data() + dim);
  }
  values.insert(values.end(), rigid_wall_forces_.begin(), rigid_wall_forces_.end());
  if (settings_.outside == Outside::remove) {
    values.insert(values.end(), {static_cast<double>(removed_points_), ledger_.removed_mass()});
  }
  return values;
}

template <int dim>
Json MpmSolver<dim>::summary() const {
  const Json locking = {{"method", settings_.locking.average_volumes ? "fbar" : "none"},
                        {"reason", settings_.locking.reason}};
  const auto method = method_in(settings_.small_cuts, grid_.basis, phase().dynamic);
  const auto name = std::find_if(small_cut_methods.begin(), small_cut_methods.end(),
                                 [&](const auto& entry) { return entry.second == method; });
  Json cuts = {{"method", name->first}, {"joined_nodes", joined_nodes_}};
  if (ghost_) {
    cuts["steps_with_ghost"] = ghost_steps_;
    cuts["facets"] = ghost_facets_;
  }
  std::vector<double> sums = {static_cast<double>(capped_domains_),
                              static_cast<double>(points_.size())};
  sum_over_ranks(comm_, std::span<double>(sums));
  const auto num_points = static_cast<std::int64_t>(sums[1]);
  log::info("{}", newton_counts_.text());
  return {{"basis", basis_name(grid_.basis)},
          {"locking", locking},
          {"bodies", settings_.bodies.size()},
          {"points", num_points},
          {"grid_cells", grid_.mesh.num_cells()},
          {"grid_nodes", grid_.mesh.num_nodes_total()},
          {"frame_bytes", MpmOutput<dim>::frame_bytes(num_points)},
          {"capped_domains", static_cast<std::int64_t>(sums[0])},
          {"phases", settings_.phases.size()},
          {"initial_displacement", initial_displacement_},
          {"small_cuts", cuts},
          {"removed_points", removed_points_},
          {"linear_solver", linear_.method_name()},
          {"factorisations", linear_.factorisations()},
          {"linear_fallbacks", linear_.fallbacks()},
          {"solutions", newton_counts_.solutions()},
          {"newton_iterations", newton_counts_.iterations()},
          {"newton", newton_counts_.json()},
          {"linear_iterations", linear_iterations_},
          {"wall_seconds", times_.seconds()}};
}

template void MpmSolver<2>::log_grid() const;
template void MpmSolver<3>::log_grid() const;
template void MpmSolver<2>::find_probe_points();
template void MpmSolver<3>::find_probe_points();
template Json MpmSolver<2>::accepted_details(std::span<const std::int32_t> cell_n) const;
template Json MpmSolver<3>::accepted_details(std::span<const std::int32_t> cell_n) const;
template void MpmSolver<2>::report_contact(StepReport& report, InterfaceValues& sent) const;
template void MpmSolver<3>::report_contact(StepReport& report, InterfaceValues& sent) const;
template void MpmSolver<2>::write_output(double time);
template void MpmSolver<3>::write_output(double time);
template std::vector<std::string> MpmSolver<2>::probe_names() const;
template std::vector<std::string> MpmSolver<3>::probe_names() const;
template std::vector<double> MpmSolver<2>::probes() const;
template std::vector<double> MpmSolver<3>::probes() const;
template Json MpmSolver<2>::summary() const;
template Json MpmSolver<3>::summary() const;

}  // namespace gabion::mpm
