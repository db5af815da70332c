// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/internal_forces.hpp"

#include <algorithm>
#include <cmath>
#include <variant>

#include "common/base/error.hpp"
#include "common/mechanics/tensor_functions.hpp"

namespace gabion::mpm {

namespace {

// A first evaluation takes the tangent of the stresses from a state where no component of du
// differs by more than this share of a cell.
constexpr double same_tangent = 1e-4;

bool is_near(std::span<const double> x, const std::vector<double>& y, double distance) {
  if (x.size() != y.size()) return false;
  for (std::size_t k = 0; k < x.size(); ++k) {
    if (std::abs(x[k] - y[k]) > distance) return false;
  }
  return true;
}

}  // namespace

template <int dim>
InternalForces<dim>::InternalForces(const Parts& parts, double cell_size, double same_strain)
    : parts_(parts), cell_size_(cell_size), given_same_strain_(same_strain) {
  f_int_.resize(static_cast<std::size_t>(parts_.nodes.size()) * dim);
  parts_.trial.resize(parts_.points.size());
  forget();
}

template <int dim>
void InternalForces<dim>::forget() {
  du_known_.clear();
  du_K_.clear();
  known_.assign(parts_.weights.groups.size(), {});
  same_strain_ = given_same_strain_;
}

template <int dim>
Matrix<dim> InternalForces<dim>::displacement_gradient(const GroupRequest& request,
                                                       std::int32_t entry) const {
  const int n = parts_.weights.num_nodes(entry);
  const std::uint8_t* local = parts_.weights.local_of(entry);
  const Vector<dim>* grad = parts_.weights.grad_of(entry);
  Matrix<dim> H = Matrix<dim>::Zero();
  for (int i = 0; i < n; ++i) {
    const std::ptrdiff_t row = static_cast<std::ptrdiff_t>(request.active[local[i]]) * dim;
    H += Eigen::Map<const Vector<dim>>(request.du.data() + row) * grad[i].transpose();
  }
  return H;
}

// Stress of one point at the end of the step, into `stress` and the trial state.
template <int dim>
template <class Law>
bool InternalForces<dim>::point_stress(const Law& law, std::int32_t entry, const Matrix<dim>& H,
                                       StressUpdate<dim>& stress, Tangent<dim>* A,
                                       std::int32_t& worst) {
  const std::int32_t p = parts_.weights.point[entry];
  if (!law.update(H, parts_.points.history[p], stress, A) || stress.J < min_J_ratio) {
    worst = p;
    return false;
  }
  parts_.trial.history[entry] = stress.state;
  parts_.trial.tau[entry] = stress.tau;
  parts_.trial.J_ratio[entry] = stress.J;
  parts_.trial.energy[entry] = stress.energy;
  parts_.trial.dissipation[entry] = stress.dissipation;
  return true;
}

// V0 P and V0 dP/dH summed over the points of a cell that share one gradient.
template <int dim>
template <class Law>
bool InternalForces<dim>::group_stress(const Law& law, const CellGroup& group, const Matrix<dim>& H,
                                       bool with_A, GroupStress& known, std::int32_t& worst) {
  StressUpdate<dim> stress;
  Tangent<dim> A;
  known.is_known = false;
  known.H = H;
  known.P.setZero();
  known.A.setZero();
  for (std::int32_t e = group.first; e < group.last; ++e) {
    if (!point_stress(law, e, H, stress, with_A ? &A : nullptr, worst)) return false;
    const double V0 = parts_.points.V0[parts_.weights.point[e]];
    known.P += V0 * stress.P;
    if (with_A) known.A += V0 * A;
  }
  known.is_known = true;
  known.has_A = with_A;
  return true;
}

// Forces and stiffness of a triangle or tetrahedron.
template <int dim>
template <class Law>
bool InternalForces<dim>::simplex_forces(const Law& law, const GroupRequest& request) {
  const CellGroup& group = parts_.weights.groups[request.number];
  const std::uint8_t* local = parts_.weights.local_of(group.first);
  const Vector<dim>* grad = parts_.weights.grad_of(group.first);
  const int n = group.num_nodes;
  const Matrix<dim> H = displacement_gradient(request, group.first);
  GroupStress& known = known_[request.number];
  const Matrix<dim> change = H - known.H;
  const double size = change.cwiseAbs().maxCoeff();
  const bool near =
      known.is_known && (known.has_A ? size <= same_strain_ : size == 0 && !request.with_K);
  if (!near && !group_stress(law, group, H, request.with_K, known, request.worst)) return false;
  request.sum.add_stress(n, local, known.P, grad);
  if (near && size > 0) {
    Matrix<dim> P_change;
    for (int aJ = 0; aJ < dim * dim; ++aJ) {
      double value = 0;
      for (int bL = 0; bL < dim * dim; ++bL) value += known.A(aJ, bL) * change(bL / dim, bL % dim);
      P_change(aJ / dim, aJ % dim) = value;
    }
    request.sum.add_stress(n, local, P_change, grad);
  }
  if (request.with_K) request.sum.add_tangent(n, local, n, known.A, grad);
  return true;
}

// Forces and stiffness of a cell whose points have gradients of their own.
template <int dim>
template <class Law>
bool InternalForces<dim>::general_forces(const Law& law, const GroupRequest& request) {
  const CellGroup& group = parts_.weights.groups[request.number];
  StressUpdate<dim> stress;
  Tangent<dim> A;
  for (std::int32_t e = group.first; e < group.last; ++e) {
    const int n = parts_.weights.num_nodes(e);
    const std::uint8_t* local = parts_.weights.local_of(e);
    const Vector<dim>* grad = parts_.weights.grad_of(e);
    const Matrix<dim> H = displacement_gradient(request, e);
    if (!point_stress(law, e, H, stress, request.with_K ? &A : nullptr, request.worst))
      return false;
    const double V0 = parts_.points.V0[parts_.weights.point[e]];
    request.sum.add_stress(n, local, V0 * stress.P, grad);
    if (request.with_K) request.sum.add_tangent(n, local, group.num_nodes, V0 * A, grad);
  }
  return true;
}

// f_int and its derivative of the cells that hold points of one body.
template <int dim>
template <class Law>
bool InternalForces<dim>::body_forces(const Law& law, std::int32_t body, std::span<const double> du,
                                      BlockMatrix<dim>* K, std::int32_t& worst) {
  const auto& weights = parts_.weights;
  CellForces<dim> sum;
  std::int32_t active[max_group_nodes<dim>];
  for (std::int32_t g = weights.body_groups[body]; g < weights.body_groups[body + 1]; ++g) {
    const CellGroup& group = weights.groups[g];
    parts_.nodes.list_active(weights.nodes_of(group), active);
    sum.set_zero(group.num_nodes, K != nullptr);
    const GroupRequest request{g, active, du, K != nullptr, sum, worst};
    const bool admissible =
        weights.constant_gradient ? simplex_forces(law, request) : general_forces(law, request);
    if (!admissible) return false;
    for (int i = 0; i < group.num_nodes; ++i) {
      double* f = f_int_.data() + static_cast<std::ptrdiff_t>(active[i]) * dim;
      for (int a = 0; a < dim; ++a) f[a] += sum.f[i * dim + a];
    }
    if (K) K->add_cell(g, sum.K);
  }
  return true;
}

template <int dim>
bool InternalForces<dim>::evaluate(std::span<const double> du, BlockMatrix<dim>* K,
                                   std::int32_t& worst) {
  const bool stress_known = std::equal(du.begin(), du.end(), du_known_.begin(), du_known_.end());
  const double near = first_evaluation_ ? same_tangent * cell_size_ : 0;
  first_evaluation_ = false;
  if (stress_known && (!K || is_near(du, du_K_, near))) {
    if (K) std::copy(K_int_.begin(), K_int_.end(), K->values().begin());
    return true;
  }
  du_known_.clear();
  std::fill(f_int_.begin(), f_int_.end(), 0.0);
  if (K) K->set_zero();
  for (std::int32_t b = 0; b < parts_.points.num_bodies(); ++b) {
    const bool admissible =
        std::visit([&](const auto& law) { return body_forces(law, b, du, K, worst); },
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
std::vector<double> InternalForces<dim>::start_forces() const {
  const auto& weights = parts_.weights;
  std::vector<double> f(f_int_.size(), 0.0);
  CellForces<dim> sum;
  std::int32_t active[max_group_nodes<dim>];
  for (const CellGroup& group : weights.groups) {
    parts_.nodes.list_active(weights.nodes_of(group), active);
    sum.set_zero(group.num_nodes, false);
    Matrix<dim> P = Matrix<dim>::Zero();
    for (std::int32_t e = group.first; e < group.last; ++e) {
      const std::int32_t p = weights.point[e];
      P += parts_.points.V0[p] * in_plane<dim>(parts_.points.tau[p]);
      if (weights.constant_gradient && e + 1 < group.last) continue;
      const std::int32_t row = weights.constant_gradient ? group.first : e;
      sum.add_stress(weights.num_nodes(row), weights.local_of(row), P, weights.grad_of(row));
      P.setZero();
    }
    for (int i = 0; i < group.num_nodes; ++i) {
      double* f_i = f.data() + static_cast<std::ptrdiff_t>(active[i]) * dim;
      for (int a = 0; a < dim; ++a) f_i[a] += sum.f[i * dim + a];
    }
  }
  return f;
}

template <int dim>
void InternalForces<dim>::finish(std::span<const double> du) {
  same_strain_ = 0;
  du_known_.clear();
  std::int32_t worst = -1;
  require(evaluate(du, nullptr, worst), "mpm_solver: an inadmissible state was accepted");
}

template class InternalForces<2>;
template class InternalForces<3>;

}  // namespace gabion::mpm
