// SPDX-License-Identifier: BSD-3-Clause
// Soil that begins under the steady flow of its pore water.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/base/log.hpp"
#include "common/mechanics/ranks/sum.hpp"
#include "common/mechanics/ranks/text.hpp"
#include "mpm_solver/checks/seepage.hpp"
#include "mpm_solver/points/retention.hpp"
#include "mpm_solver/step/seepage_step.hpp"
#include "mpm_solver/step/steady_seepage.hpp"
#include "mpm_solver/stress/trial_points.hpp"

namespace gabion::mpm {

namespace {

// Steps are multiples of the time n h / k in which water crosses a cell. In these full pores store
// less than 1e-7 of what seeps, and yet so much that the matrix is not singular where nothing sets
// the pressures. Pores with air store more, so that their steps grow.
constexpr double long_step = 1e4, longest_step = 1e5, longest_step_with_air = 1e7;
constexpr double first_step_with_air = 1, growth = 30;

// Change of the pressures in the last step, by their size, that passes for none.
constexpr double steady = 1e-8;

constexpr int most_steps = 60;
constexpr int most_changes_of_outlets = 60;

// Share of a change of the pressures at the start that is left where something sets the pressure.
constexpr double left_by_borders = 1e-3;

template <int dim>
bool lets_air_in(const Body<dim>& body) {
  return drains(body) && gives_way(*body.water);
}

template <int dim>
double largest_difference(MPI_Comm comm, std::span<const double> a, std::span<const double> b) {
  double largest = 0;
  for (std::size_t p = 0; p < a.size(); ++p) largest = std::max(largest, std::abs(a[p] - b[p]));
  return max_over_ranks(comm, largest);
}

}  // namespace

// Let the water of the points seep for a time through the skeleton at rest.
template <int dim>
void SeepageStep<dim>::flow_for(double dt, const Vector<dim>& gravity) {
  flow_start_.dt = dt;
  make_water(flow_start_, flow_start_.time, gravity);
  open_borders(flow_start_, gravity);
  water_->hold_outlets();
  const auto& model = this->parts_.model;
  double least = std::numeric_limits<double>::infinity();
  for (const Body<dim>& body : model.settings.bodies) {
    if (drains(body)) least = std::min(least, body.water->permeability);
  }
  const double unit = least * dt * std::pow(model.cell_size, dim - 1);
  RigidSeepage<dim> problem(*this->equilibrium_, *water_,
                            drained_nodes(flow_start_, flow_start_.time, gravity), unit);
  NewtonSettings settings = model.settings.newton;
  settings.residual_tolerance = 1e-10;
  settings.max_iterations = 50;
  std::vector<double> x(water_->volumes().size() * (dim + 1), 0.0);
  NewtonMatrix<dim + 1> matrix{*K_, solver_};
  solve_newton<dim + 1>(problem, matrix, settings, x, this->parts_.times);
  for (int k = 0; water_->update_outlets(); ++k) {
    if (k == most_changes_of_outlets) {
      throw ConvergenceError("places where water leaves still change");
    }
    solve_newton<dim + 1>(problem, matrix, settings, x, this->parts_.times);
  }
  std::vector<double> r(x.size());
  problem.evaluate(x, r, nullptr);
  heads_of_flow_.clear();
  const auto& grid_node = this->parts_.soil.nodes().grid_node;
  for (std::size_t i = 0; i < grid_node.size(); ++i) {
    if (water_->wet()[i] != 0) heads_of_flow_[grid_node[i]] = problem.heads()[i];
  }
  discharge_ = problem.leaving() / dt;
}

// @param unit  time n h / k [s]
template <int dim>
void SeepageStep<dim>::flow_until_steady(double unit, const Vector<dim>& gravity,
                                         const std::string& where) {
  auto& points = this->parts_.state.points;
  const auto& model = this->parts_.model;
  const bool with_air = std::ranges::any_of(model.settings.bodies, lets_air_in<dim>);
  const double longest = with_air ? longest_step_with_air : longest_step;
  double step = with_air ? first_step_with_air : long_step;
  std::vector<double> before(points.size(), 0.0);
  std::string failure = "it is not steady yet";
  for (int k = 0; k < most_steps; ++k) {
    try {
      flow_for(step * unit, gravity);
    } catch (const ConvergenceError& error) {
      failure = error.what();
      step /= growth;
      continue;
    }
    water_->store(points);
    const std::vector<double> now = pressures_of_points();
    const std::vector<double> none(now.size(), 0.0);
    const double size =
        largest_difference<dim>(model.comm, now, none) + gravity.norm() * model.cell_size;
    const double change = largest_difference<dim>(model.comm, now, before);
    before = now;
    if (step >= long_step && change <= steady * size) {
      log::debug("steady seepage: {} steps, the last one of {:.3g} s", k + 1, step * unit);
      return;
    }
    step = std::min(growth * step, longest);
  }
  throw ConfigError(
      fmt::format("{}: found no steady flow after {} steps: {}", where, most_steps, failure));
}

template <int dim>
std::vector<double> SeepageStep<dim>::pressures_of_points() const {
  const auto& point = this->parts_.soil.weights().point;
  std::vector<double> result(point.size());
  for (std::size_t e = 0; e < point.size(); ++e) result[point[e]] = water_->pressures()[e];
  return result;
}

// Refuse a flow that keeps a change of the pressures it begins with: then nothing sets them.
template <int dim>
void SeepageStep<dim>::require_one_flow(const Vector<dim>& gravity, const std::string& where) {
  auto& points = this->parts_.state.points;
  const auto& model = this->parts_.model;
  const std::vector<double> found = pressures_of_points();
  const auto body = std::ranges::find_if(model.settings.bodies, drains<dim>);
  const double change = body->water->density * gravity.norm() * model.cell_size;
  change_pressures<dim>(model.settings.bodies, -change, points);
  flow_for(flow_start_.dt, gravity);
  water_->store(points);
  const std::vector<double> again = pressures_of_points();
  std::string own;
  for (std::int32_t p = 0; p < points.size(); ++p) {
    if (std::abs(again[p] - found[p]) <= left_by_borders * change) continue;
    own = fmt::format(
        "{}: found nothing that sets the pressure of the water at ({:.4g}), where it may be {:.4g} "
        "or {:.4g} Pa, allowed: a pool at the surface of the soil, a wall that is \"drained\", or "
        "\"rain\" or \"inflow\" that leaves elsewhere; for water at rest: \"pore_pressure\" "
        "\"at_rest\"",
        where, fmt::join(points.x[p].data(), points.x[p].data() + dim, ", "), found[p], again[p]);
    break;
  }
  const std::string text = first_text(model.comm, own);
  if (!text.empty()) throw ConfigError(text);
}

template <int dim>
SteadyFlow SeepageStep<dim>::find_steady_flow(const StepStart& start, const Vector<dim>& gravity,
                                              const std::string& where) {
  const auto& model = this->parts_.model;
  this->start_ = flow_start_ = start;
  double unit = 0;
  for (const Body<dim>& body : model.settings.bodies) {
    if (!drains(body)) continue;
    unit = std::max(unit, body.water->porosity * model.cell_size / body.water->permeability);
  }
  make_water(start, start.time, gravity);
  this->make_equilibrium({.start = gravity, .end = gravity});
  begin_matrix();
  flow_until_steady(unit, gravity, where);
  require_one_flow(gravity, where);
  return {.pressures = pressures_of_points(), .discharge = discharge_};
}

template <int dim>
void SeepageStep<dim>::balance_flow(const StepStart& start, const Vector<dim>& gravity,
                                    const std::string& where) {
  this->start_ = start;
  make_water(start, start.time, gravity);
  this->make_equilibrium({.start = gravity, .end = gravity});
  begin_matrix();
  DrainedNodes all;  // every pressure is given; nodes of no point of this rank have no meaning
  for (const std::int32_t node : this->parts_.soil.nodes().grid_node) {
    const auto head = heads_of_flow_.find(node);
    all.nodes.push_back(static_cast<std::int32_t>(all.nodes.size()));
    all.q.push_back(head == heads_of_flow_.end() ? 0 : head->second);
    all.p.push_back(0);
  }
  balance_.emplace(*this->equilibrium_, *water_, this->system_.K(), all);
  NewtonSettings settings = this->parts_.model.settings.newton;
  settings.max_iterations = this->parts_.model.settings.iterations_without_inertia;
  const auto n = static_cast<std::size_t>(this->parts_.soil.nodes().size());
  x_.assign(n * (dim + 1), 0.0);
  NewtonMatrix<dim + 1> matrix{*K_, solver_};
  try {
    solve_newton<dim + 1>(*balance_, matrix, settings, x_, this->parts_.times);
  } catch (const ConvergenceError& error) {
    throw ConfigError(
        fmt::format("{}: found no balance of the soil under its steady flow, allowed: "
                    "a flow that the soil bears ({})",
                    where, error.what()));
  }
  accept_in_place();
  balance_.reset();
}

// Give the points the stresses of the last solution. They stay where they are: what changes is
// their volume free of stress.
template <int dim>
void SeepageStep<dim>::accept_in_place() {
  std::vector<double> r(x_.size());
  balance_->evaluate(x_, r, nullptr);
  this->du_ = balance_->displacement(x_);
  this->equilibrium_->internal_forces().finish(this->du_);
  water_->finish(this->du_);
  auto& points = this->parts_.state.points;
  const std::vector<double> J_n = points.J;
  accept_stresses(this->parts_.soil.weights(), this->parts_.trial, points);
  water_->store(points);
  for (std::int32_t p = 0; p < points.size(); ++p) {
    const double ratio = J_n[p] / points.J[p];
    points.V0[p] *= ratio;
    points.m[p] *= ratio;
  }
}

template <int dim>
double SeepageStep<dim>::pressure_of_flow(std::int32_t body, const Vector<dim>& x) const {
  return head_at<dim>(*this->parts_.model.grid.box, heads_of_flow_, x) + water_->at_rest(body, x);
}

template std::vector<double> SeepageStep<2>::pressures_of_points() const;
template std::vector<double> SeepageStep<3>::pressures_of_points() const;
template void SeepageStep<2>::flow_for(double, const Vector<2>&);
template void SeepageStep<3>::flow_for(double, const Vector<3>&);
template void SeepageStep<2>::flow_until_steady(double, const Vector<2>&, const std::string&);
template void SeepageStep<3>::flow_until_steady(double, const Vector<3>&, const std::string&);
template void SeepageStep<2>::require_one_flow(const Vector<2>&, const std::string&);
template void SeepageStep<3>::require_one_flow(const Vector<3>&, const std::string&);
template SteadyFlow SeepageStep<2>::find_steady_flow(const StepStart&, const Vector<2>&,
                                                     const std::string&);
template SteadyFlow SeepageStep<3>::find_steady_flow(const StepStart&, const Vector<3>&,
                                                     const std::string&);
template void SeepageStep<2>::accept_in_place();
template void SeepageStep<3>::accept_in_place();
template void SeepageStep<2>::balance_flow(const StepStart&, const Vector<2>&, const std::string&);
template void SeepageStep<3>::balance_flow(const StepStart&, const Vector<3>&, const std::string&);
template double SeepageStep<2>::pressure_of_flow(std::int32_t, const Vector<2>&) const;
template double SeepageStep<3>::pressure_of_flow(std::int32_t, const Vector<3>&) const;

}  // namespace gabion::mpm
