// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/stress/seepage_forces.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "common/base/require.hpp"
#include "mpm_solver/points/retention.hpp"
#include "mpm_solver/stress/seepage_group.hpp"

namespace gabion::mpm {

namespace {

// Share of the exact variance of a linear pressure over a cell that its points see: two points a
// direction under gimp have 3/4 of it, splines less. The inverse goes to the stabilisation.
constexpr double points_see_of_gimp = 4.0 / 3, points_see_of_splines = 2.5;

// Nodes that points hardly weigh on would have any pressure: nodes of a group are tied to each
// other by this share of what the group stores and lets seep.
constexpr double tie_share = 1e-6;

// tau_st of a body, (W14) [1/Pa].
template <int dim>
double stabilisation(const StressParts<dim>& parts, const SeepageStepData<dim>& step,
                     std::int32_t body) {
  const Body<dim>& soil = parts.bodies[body];
  const double h = step.cell_size;
  const double M = (step.by_inertia ? 0 : skeleton_modulus(soil)) +
                   step.inertia_slope * soil.material.density * h * h;
  double least = 1;
  const auto& points = parts.points;
  for (std::int32_t p = points.body_starts[body]; p < points.body_starts[body + 1]; ++p) {
    double ratio = soil.water->mobility_ratio(points.J[p]);
    if (gives_way(*soil.water)) {
      const double pressure = water_pressure(*soil.water, points.water[p], points.J[p]);
      ratio *= retention_at(*soil.water, pressure).mobility;
    }
    least = std::min(least, ratio);
  }
  least = -parts.nodes.shared.largest(-least);
  const double drained = 4 * soil.water->mobility() * least * M * step.dt / (h * h);
  const double alpha =
      parts.points.half_length.empty() ? points_see_of_splines : points_see_of_gimp;
  return alpha * 3 / M * std::max(0.0, 1 - drained);
}

}  // namespace

template <int dim>
SeepageForces<dim>::SeepageForces(const StressParts<dim>& parts, const SeepageStepData<dim>& step)
    : parts_(parts), step_(step) {
  const std::size_t n = static_cast<std::size_t>(parts_.nodes.size());
  f_.assign(n * dim, 0.0);
  for (auto* values : {&r_, &squeezed_, &seeped_, &left_}) values->assign(n, 0.0);
  const auto& weights = parts_.weights;
  p_n_.assign(weights.point.size(), 0.0);
  for (std::size_t b = 0; b < parts_.bodies.size(); ++b) {
    const Body<dim>& body = parts_.bodies[b];
    const bool drains = body.water && body.water->drains();
    tau_st_.push_back(drains ? stabilisation(parts_, step_, static_cast<std::int32_t>(b)) : 0);
    if (drains) modulus_ = std::max(modulus_, skeleton_modulus(body));
  }
  for (std::size_t g = 0; g < weights.groups.size(); ++g) {
    const CellGroup& group = weights.groups[g];
    const auto& water = parts_.bodies[group.body].water;
    if (!water || !water->drains()) continue;
    groups_.push_back(static_cast<std::int32_t>(g));
    for (std::int32_t e = group.first; e < group.last; ++e) {
      const std::int32_t p = weights.point[e];
      p_n_[e] = water_pressure(*water, parts_.points.water[p], parts_.points.J[p]);
    }
  }
  if (!step_.pools.empty()) list_pool_pressures();
  p_ = p_n_;
  J_.assign(p_.size(), 1.0);
  list_wet();
  q_start_ = start_heads();
}

template <int dim>
void SeepageForces<dim>::list_wet() {
  std::vector<double> groups_at(r_.size(), 0.0);
  for (const std::int32_t g : groups_) {
    const CellGroup& group = parts_.weights.groups[g];
    const std::int32_t* active = parts_.nodes.of_groups.data() + group.first_node;
    for (int k = 0; k < group.num_nodes; ++k) groups_at[active[k]] += 1;
  }
  parts_.nodes.shared.sum(groups_at, 1);
  wet_.assign(r_.size(), 0);
  for (std::size_t i = 0; i < wet_.size(); ++i) wet_[i] = groups_at[i] > 0 ? 1 : 0;
}

template <int dim>
void SeepageForces<dim>::list_pool_pressures() {
  const auto& weights = parts_.weights;
  f_pool_.assign(f_.size(), 0.0);
  p_pool_.assign(weights.point.size(), 0.0);
  p_pool_slope_.assign(weights.point.size(), Vector<dim>::Zero());
  for (const std::int32_t g : groups_) {
    const CellGroup& group = weights.groups[g];
    for (std::int32_t e = group.first; e < group.last; ++e) {
      const Vector<dim>& x = parts_.points.x[weights.point[e]];
      p_pool_[e] = step_.pools.template pressure<dim>(x);
      p_pool_slope_[e] = step_.pools.template gradient<dim>(x);
    }
  }
}

// Volume by pressure with which a group ties changes of q at its nodes, over its own [1/Pa].
template <int dim>
double SeepageForces<dim>::tie_of_nodes(const CellGroup& group) const {
  const PoreWater& water = *parts_.bodies[group.body].water;
  const double h = step_.cell_size;
  return tie_share *
         (tau_st_[group.body] + 1 / water.modulus() + water.mobility() * step_.dt / (h * h));
}

template <int dim>
double SeepageForces<dim>::at_rest(std::int32_t body, const Vector<dim>& x) const {
  return parts_.bodies[body].water->density * step_.gravity.dot(x);
}

template <int dim>
std::vector<double> SeepageForces<dim>::start_heads() const {
  std::vector<double> q(r_.size(), 0.0), sum(r_.size(), 0.0);
  const auto& weights = parts_.weights;
  for (const std::int32_t g : groups_) {
    const CellGroup& group = weights.groups[g];
    const std::int32_t* active = parts_.nodes.of_groups.data() + group.first_node;
    for (std::int32_t e = group.first; e < group.last; ++e) {
      const double head = p_n_[e] - at_rest(group.body, parts_.points.x[weights.point[e]]);
      for (int i = 0; i < weights.num_nodes(e); ++i) {
        const double share = weights.volume[e] * weights.N_of(e)[i];
        const std::int32_t node = active[weights.local_of(e)[i]];
        q[node] += share * head;
        sum[node] += share;
      }
    }
  }
  parts_.nodes.shared.sum(q, sum, 1);
  for (std::size_t i = 0; i < q.size(); ++i) q[i] = sum[i] > 0 ? q[i] / sum[i] : 0;
  return q;
}

template <int dim>
void SeepageForces<dim>::gather(const CellGroup& group, const Trial& trial, Group& work) const {
  const auto nodes = parts_.weights.nodes_of(group);
  parts_.nodes.gather(nodes, trial.du, work.du.data());
  parts_.nodes.list_active(nodes, work.active.data());
  for (int i = 0; i < group.num_nodes; ++i) {
    work.q[i] = trial.q[work.active[i]];
    work.change_of_q[i] = work.q[i] - q_start_[work.active[i]];
  }
}

// Points of a group and their sums.
template <int dim>
bool SeepageForces<dim>::sum_up(const CellGroup& group, Group& work, RefusedPoint& worst) const {
  const auto& weights = parts_.weights;
  const PoreWater& water = *parts_.bodies[group.body].water;
  work.points.resize(group.last - group.first);
  work.V = work.Vj = work.pV = work.p_nV = work.p_poolV = work.density = 0;
  work.borneV = work.borne_nV = 0;
  std::fill_n(work.N.begin(), group.num_nodes, 0.0);
  std::fill_n(work.borne_N.begin(), group.num_nodes, 0.0);
  std::fill_n(work.change.begin(), group.num_nodes, Vector<dim>::Zero());
  for (std::int32_t e = group.first; e < group.last; ++e) {
    Work& point = work.points[e - group.first];
    const std::int32_t p = weights.point[e];
    point.entry = e;
    point.V0 = weights.volume[e];
    point.V = point.V0 * parts_.points.J[p];
    const Matrix<dim> F =
        Matrix<dim>::Identity() + displacement_gradient<dim>(weights, e, work.du.data());
    point.j = F.determinant();
    if (!(point.j > min_J_ratio)) {
      worst = {p, Refusal::squeezed};
      return false;
    }
    const Matrix<dim> G = F.inverse().transpose();
    const Vector<dim> weight = water.density * step_.gravity;
    point.p = at_rest(group.body, parts_.points.x[p]);
    point.p_n = p_n_[e];
    if (!p_pool_.empty()) point.p_pool = p_pool_[e], point.p_pool_slope = p_pool_slope_[e];
    point.grad_p = G * weight;
    for (int i = 0; i < weights.num_nodes(e); ++i) {
      const int k = weights.local_of(e)[i];
      point.g[i] = G * weights.grad_of(e)[i];
      point.p += weights.N_of(e)[i] * work.q[k];
      point.grad_p += work.q[k] * point.g[i];
      work.N[k] += point.V * weights.N_of(e)[i];
      work.change[k] += point.V * point.j * point.g[i];
    }
    bear(water, point);
    for (int i = 0; i < weights.num_nodes(e); ++i) {
      work.borne_N[weights.local_of(e)[i]] += point.V * point.borne_slope * weights.N_of(e)[i];
    }
    work.V += point.V;
    work.Vj += point.V * point.j;
    work.pV += point.V * point.p;
    work.p_nV += point.V * point.p_n;
    work.p_poolV += point.V * point.p_pool;
    work.borneV += point.V * point.borne;
    work.borne_nV += point.V * point.borne_n;
    work.density += point.V * point.density;
  }
  work.density /= work.V;
  for (int k = 0; k < group.num_nodes; ++k) {
    work.N[k] /= work.V;
    work.borne_N[k] /= work.V;
  }
  return fill_pores(group, work, worst);
}

// Find the pores of the points, and the flow through them.
template <int dim>
bool SeepageForces<dim>::fill_pores(const CellGroup& group, Group& work,
                                    RefusedPoint& worst) const {
  const auto& weights = parts_.weights;
  const PoreWater& water = *parts_.bodies[group.body].water;
  for (Work& point : work.points) {
    const std::int32_t p = weights.point[point.entry];
    const double J = parts_.points.J[p] * (step_.averages ? work.Vj / work.V : point.j);
    if (!water.admits(J)) {
      worst = {p, Refusal::pores_closed};
      return false;
    }
    point.m = water.pores(J);
    point.kappa *= water.mobility() * water.mobility_ratio(J);
    if (gives_way(water)) {
      point.held_slope *= point.V0 * point.m;
    } else {
      point.held_slope = point.density * point.V0 * point.m * point.grown / water.bulk_modulus;
    }
    point.kappa_slope = water.mobility_slope(J);
    point.w = point.kappa * (water.density * step_.gravity - point.grad_p);
  }
  return true;
}

template <int dim>
void SeepageForces<dim>::add_forces(const CellGroup&, Group& work) {
  const auto& weights = parts_.weights;
  for (const Work& point : work.points) {
    const double p = work.excess(point, step_.averages), Vj = point.V * point.j;
    for (int i = 0; i < weights.num_nodes(point.entry); ++i) {
      const std::ptrdiff_t node = work.active[weights.local_of(point.entry)[i]];
      for (int d = 0; d < dim; ++d) f_[node * dim + d] += Vj * p * point.g[i][d];
    }
    if (p_pool_.empty()) continue;
    const double p_pool = work.pool_pressure(point, step_.averages);
    for (int i = 0; i < weights.num_nodes(point.entry); ++i) {
      const std::ptrdiff_t node = work.active[weights.local_of(point.entry)[i]];
      const double N = weights.N_of(point.entry)[i];
      for (int d = 0; d < dim; ++d) {
        const double along = Vj * N * point.p_pool_slope[d];
        f_[node * dim + d] -= along;
        f_pool_[node * dim + d] -= along + Vj * p_pool * point.g[i][d];
      }
    }
  }
}

template <int dim>
double SeepageForces<dim>::pool_work(std::span<const double> du) const {
  double work = 0;
  for (std::size_t k = 0; k < f_pool_.size(); ++k) work += f_pool_[k] * du[k];
  return work;
}

template <int dim>
Vector<dim> SeepageForces<dim>::pool_force() const {
  Vector<dim> force = Vector<dim>::Zero();
  for (std::size_t k = 0; k < f_pool_.size(); ++k) force[k % dim] += f_pool_[k];
  return force;
}

template <int dim>
void SeepageForces<dim>::add_volumes(const CellGroup& group, Group& work) {
  const auto& weights = parts_.weights;
  const PoreWater& water = *parts_.bodies[group.body].water;
  const double tau = tau_st_[group.body];
  double unstable = 0;
  for (const Work& point : work.points) {
    const double squeezed = point.density * point.V * (point.j - 1);
    const double stored = point.density * point.V0 * point.m * point.change;
    const double jump = (point.p - work.pV / work.V) - (point.p_n - work.p_nV / work.V);
    const double stable = point.V * tau * jump;
    unstable += stable;
    weight_work_ += step_.dt * point.V * point.j * water.density * step_.gravity.dot(point.w);
    for (int i = 0; i < weights.num_nodes(point.entry); ++i) {
      const std::int32_t node = work.active[weights.local_of(point.entry)[i]];
      const double N = weights.N_of(point.entry)[i];
      const double seeped = step_.dt * point.V * point.j * point.g[i].dot(point.w);
      if (!step_.averages) {
        squeezed_[node] += squeezed * N;
        r_[node] += squeezed * N;
      }
      seeped_[node] += seeped;
      r_[node] += (stored + stable) * N - seeped;
    }
  }
  double mean = 0;
  for (int k = 0; k < group.num_nodes; ++k) mean += work.change_of_q[k] / group.num_nodes;
  const double tie = tie_of_nodes(group) * work.V;
  for (int k = 0; k < group.num_nodes; ++k) {
    r_[work.active[k]] += tie * (work.change_of_q[k] - mean);
    const double squeezed = step_.averages ? work.density * (work.Vj - work.V) * work.N[k] : 0;
    squeezed_[work.active[k]] += squeezed;
    r_[work.active[k]] += squeezed - unstable * work.N[k];
  }
}

template <int dim>
bool SeepageForces<dim>::evaluate(const Trial& trial, BlockMatrix<block_size>* K,
                                  RefusedPoint& worst) {
  const SharedNodes& shared = parts_.nodes.shared;
  if (!shared.all(evaluate_groups(trial, K, worst))) return false;
  shared.sum(r_, squeezed_, 1);
  shared.sum(seeped_, 1);
  outflow_ = shared.total(outflow_);
  if (step_.rain.isZero(0)) return true;
  rain_in_ = shared.total(rain_in_);
  rain_run_off_ = shared.total(rain_run_off_);
  return true;
}

template <int dim>
bool SeepageForces<dim>::evaluate_groups(const Trial& trial, BlockMatrix<block_size>* K,
                                         RefusedPoint& worst) {
  for (auto* values : {&f_, &r_, &squeezed_, &seeped_, &left_, &f_pool_}) {
    std::fill(values->begin(), values->end(), 0.0);
  }
  weight_work_ = outflow_ = inflow_work_ = rain_in_ = rain_run_off_ = leaving_ = 0;
  Group work;
  for (const std::int32_t g : groups_) {
    const CellGroup& group = parts_.weights.groups[g];
    gather(group, trial, work);
    if (!sum_up(group, work, worst)) return false;
    add_forces(group, work);
    add_volumes(group, work);
    for (const Work& point : work.points) {
      p_[point.entry] = point.p;
      J_[point.entry] = point.m + (1 - parts_.bodies[group.body].water->porosity);
    }
    if (K) add_stiffness(group, work);
    if (!outlets_.empty()) add_outflow(group, work, K != nullptr);
    if (inlets_) {
      const auto fed = inlets_->add(group, work.q.data(), work.active.data(), r_);
      outflow_ -= fed.volume;
      leaving_ += fed.leaving;
      inflow_work_ += fed.work;
    }
    if (K) K->add_cell(g, work.K.data());
  }
  for (std::size_t i = 0; i < gone_.size(); ++i) r_[i] += gone_[i];
  weight_work_ += weight_work_gone_;
  outflow_ += outflow_gone_;
  return true;
}

template <int dim>
void SeepageForces<dim>::carry_on() {
  gone_.resize(r_.size(), 0.0);
  for (std::size_t i = 0; i < gone_.size(); ++i) gone_[i] += left_[i] - seeped_[i];
  weight_work_gone_ = weight_work_;
  outflow_gone_ = outflow_;
}

template <int dim>
void SeepageForces<dim>::find_start_forces() {
  std::fill(f_.begin(), f_.end(), 0.0);
  const std::vector<double> still(f_.size(), 0.0), none(r_.size(), 0.0);
  Group work;
  RefusedPoint worst;
  for (const std::int32_t g : groups_) {
    const CellGroup& group = parts_.weights.groups[g];
    gather(group, {.du = still, .q = none}, work);
    require(sum_up(group, work, worst), "mpm_solver: pores of the accepted state are closed");
    work.borneV = work.borne_nV;
    for (Work& point : work.points) point.borne = point.borne_n;
    add_forces(group, work);
  }
}

template <int dim>
double SeepageForces<dim>::volume_scale() const {
  const SharedNodes& shared = parts_.nodes.shared;
  return std::max(shared.norm(squeezed_), shared.norm(seeped_));
}

template class SeepageForces<2>;
template class SeepageForces<3>;

}  // namespace gabion::mpm
