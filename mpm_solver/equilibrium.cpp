// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/equilibrium.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <variant>

#include "common/mechanics/ranks/sum.hpp"
#include "mpm_solver/cell_forces.hpp"

namespace gabion::mpm {

namespace {

// A node that points hardly weigh on gets this share of the mean nodal mass: without it the matrix
// is singular there once the soil around it has no stiffness. Small enough to be far below the
// error of the scheme, large enough for double precision.
constexpr double mass_floor = 1e-8;

// A step that squeezes a point below this share of its volume is inadmissible.
constexpr double min_J_ratio = 0.1;

// A first evaluation takes the tangent of the stresses from a state where no component of du differs
// by more than this share of a cell.
constexpr double same_tangent = 1e-4;

// Where soil flies freely no force is left to compare the residual with. The force that would stop
// a node within the step counts by this share.
constexpr double share_of_stopping = 1e-3;

double norm(std::span<const double> x) {
  double sum = 0;
  for (const double value : x) sum += value * value;
  return std::sqrt(sum);
}

bool is_near(std::span<const double> x, const std::vector<double>& y, double distance) {
  if (x.size() != y.size()) return false;
  for (std::size_t k = 0; k < x.size(); ++k) {
    if (std::abs(x[k] - y[k]) > distance) return false;
  }
  return true;
}

}  // namespace

template <int dim>
Equilibrium<dim>::Equilibrium(const Parts& parts)
    : parts_(parts), inertia_m_(parts.nodes.m) {
  const auto& nodes = parts_.nodes;
  double total = 0;
  for (const double mass : nodes.m) total += mass;
  const double floor = mass_floor * total / std::max(1, nodes.size());
  for (double& mass : inertia_m_) mass = std::max(mass, floor);
  v_.assign(nodes.v.empty() ? nullptr : nodes.v.front().data(),
            nodes.v.empty() ? nullptr : nodes.v.front().data() + nodes.v.size() * dim);
  a_.assign(nodes.a.empty() ? nullptr : nodes.a.front().data(),
            nodes.a.empty() ? nullptr : nodes.a.front().data() + nodes.a.size() * dim);
  parts_.walls.project(v_);
  parts_.walls.project(a_);
  f_int_.resize(v_.size());
  parts_.trial.resize(parts_.points.size());
}

template <int dim>
void Equilibrium<dim>::pattern(std::vector<std::int32_t>& offsets,
                               std::vector<std::int32_t>& cell_nodes) const {
  offsets.assign(1, 0);
  cell_nodes.clear();
  for (const CellGroup& group : parts_.weights.groups) {
    for (const std::int32_t node : parts_.grid.mesh.cell(group.cell)) {
      cell_nodes.push_back(parts_.nodes.active[node]);
    }
    offsets.push_back(static_cast<std::int32_t>(cell_nodes.size()));
  }
  if (rank_of(parts_.comm) == 0) {
    for (const auto& boundary : parts_.boundaries) boundary.append_cells(offsets, cell_nodes);
  }
}

// Stress of the points of one body, forces and stiffness of the cells they lie in.
template <int dim>
template <class Law>
bool Equilibrium<dim>::body_forces(const Law& law, std::int32_t body, std::span<const double> du,
                                   std::span<double> f_int, BlockMatrix<dim>* K,
                                   std::int32_t& worst) {
  const auto& weights = parts_.weights;
  const int n = weights.nodes_per_cell;
  CellForces<dim> sum;
  StressUpdate<dim> stress;
  Tangent<dim> A;
  for (std::int32_t g = weights.body_groups[body]; g < weights.body_groups[body + 1]; ++g) {
    const CellGroup& group = weights.groups[g];
    const auto cell = parts_.grid.mesh.cell(group.cell);
    const double* du_nodes[max_cell_nodes];
    double* f_nodes[max_cell_nodes];
    for (int i = 0; i < n; ++i) {
      const std::ptrdiff_t at = static_cast<std::ptrdiff_t>(parts_.nodes.active[cell[i]]) * dim;
      du_nodes[i] = du.data() + at;
      f_nodes[i] = f_int.data() + at;
    }
    sum.set_zero(n, K != nullptr);
    Matrix<dim> H, P_sum = Matrix<dim>::Zero();
    Tangent<dim> A_sum = Tangent<dim>::Zero();
    for (std::int32_t e = group.first; e < group.last; ++e) {
      const bool new_gradient = e == group.first || !weights.constant_gradient;
      const Vector<dim>* grad = weights.grad_of(weights.constant_gradient ? group.first : e);
      if (new_gradient) {
        H.setZero();
        for (int i = 0; i < n; ++i) {
          H += Eigen::Map<const Vector<dim>>(du_nodes[i]) * grad[i].transpose();
        }
      }
      const std::int32_t p = weights.point[e];
      if (!law.update(H, parts_.points.history[p], stress, K ? &A : nullptr) ||
          stress.J < min_J_ratio) {
        worst = p;
        return false;
      }
      parts_.trial.history[e] = stress.state;
      parts_.trial.tau[e] = stress.tau;
      parts_.trial.J_ratio[e] = stress.J;
      parts_.trial.energy[e] = stress.energy;
      const double V0 = parts_.points.V0[p];
      if (weights.constant_gradient) {
        P_sum += V0 * stress.P;
        if (K) A_sum += V0 * A;
      } else {
        sum.add_stress(n, V0 * stress.P, grad);
        if (K) sum.add_tangent(n, V0 * A, grad);
      }
    }
    if (weights.constant_gradient) {
      sum.add_stress(n, P_sum, weights.grad_of(group.first));
      if (K) sum.add_tangent(n, A_sum, weights.grad_of(group.first));
    }
    for (int i = 0; i < n; ++i) {
      for (int a = 0; a < dim; ++a) f_nodes[i][a] += sum.f[i * dim + a];
    }
    if (K) K->add_cell(g, sum.K);
  }
  return true;
}

template <int dim>
bool Equilibrium<dim>::internal_forces(std::span<const double> du, BlockMatrix<dim>* K,
                                       std::int32_t& worst) {
  const bool stress_known = std::equal(du.begin(), du.end(), du_known_.begin(), du_known_.end());
  const double near = first_evaluation_ ? same_tangent * parts_.cell_size : 0;
  first_evaluation_ = false;
  if (stress_known && (!K || is_near(du, du_K_, near))) {
    if (K) std::copy(K_int_.begin(), K_int_.end(), K->values().begin());
    return true;
  }
  du_known_.clear();
  std::fill(f_int_.begin(), f_int_.end(), 0.0);
  if (K) K->set_zero();
  for (std::int32_t b = 0; b < parts_.points.num_bodies(); ++b) {
    const bool admissible = std::visit(
        [&](const auto& law) { return body_forces(law, b, du, f_int_, K, worst); },
        parts_.bodies[b].material.law);
    if (!admissible) return false;
  }
  du_known_.assign(du.begin(), du.end());
  if (K) {
    du_K_ = du_known_;
    K_int_.assign(K->values().begin(), K->values().end());
  }
  return true;
}

template <int dim>
Evaluation Equilibrium<dim>::evaluate(std::span<const double> du, std::span<double> r,
                                      BlockMatrix<dim>* K) {
  Evaluation result;
  std::int32_t worst = -1;
  const bool admissible = internal_forces(du, K, worst);
  if (max_over_ranks(parts_.comm, admissible ? 0 : 1) > 0) {
    result.admissible = false;
    if (worst >= 0) {
      result.reason = fmt::format("material point {} would be squeezed below {} of its volume",
                                  parts_.points.id[worst], min_J_ratio);
    }
    return result;
  }
  const bool root = rank_of(parts_.comm) == 0;
  f_sum_ = f_int_;
  sum_over_ranks(parts_.comm, std::span<double>(f_sum_));
  std::fill(r.begin(), r.end(), 0.0);
  if (root) {
    for (auto& boundary : parts_.boundaries) boundary.add_forces(du, r, K);
  }
  if (!parts_.boundaries.empty()) sum_over_ranks(parts_.comm, r);

  const double external = add_body_forces(du, r, root ? K : nullptr);
  parts_.walls.project(r);
  if (K) K->constrain(parts_.walls.constrained(), parts_.walls.projectors(), root);
  result.force_scale = std::max(norm(f_sum_), external);
  result.admissible = std::isfinite(result.force_scale) && std::isfinite(norm(r));
  if (!result.admissible) result.reason = "forces are not finite";
  return result;
}

// Add f_ext - f_int - f_inertia to r and the inertia to K.
template <int dim>
double Equilibrium<dim>::add_body_forces(std::span<const double> du, std::span<double> r,
                                         BlockMatrix<dim>* K) const {
  const double dt = parts_.dt;
  const NewmarkBossak& scheme = parts_.scheme;
  const double slope = scheme.inertia_slope(dt);
  double external = 0, inertial = 0, stopping = 0;
  for (std::int32_t i = 0; i < parts_.nodes.size(); ++i) {
    const double mass = inertia_m_[i];
    for (int d = 0; d < dim; ++d) {
      const std::size_t k = static_cast<std::size_t>(i) * dim + d;
      const double a_new = scheme.acceleration(du[k], v_[k], a_[k], dt);
      const double f_inertia = mass * scheme.inertia(a_new, a_[k]);
      const double f_ext = mass * parts_.gravity[d];
      r[k] += f_ext - f_inertia - f_sum_[k];
      external += f_ext * f_ext;
      inertial += f_inertia * f_inertia;
      const double f_stop = share_of_stopping * mass * v_[k] / dt;
      stopping += f_stop * f_stop;
    }
    if (K) K->add_diagonal(i, mass * slope);
  }
  return std::sqrt(std::max({external, inertial, stopping}));
}

template class Equilibrium<2>;
template class Equilibrium<3>;

}  // namespace gabion::mpm
