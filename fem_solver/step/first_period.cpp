// SPDX-License-Identifier: BSD-3-Clause
#include "fem_solver/step/first_period.hpp"

#include <petscsys.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <vector>

#include "common/base/error.hpp"
#include "common/base/log.hpp"
#include "common/mechanics/petsc/linear_solver.hpp"

namespace gabion::fem {

namespace {

constexpr int num_vectors = 12;
constexpr double fewest_steps = 10;  // of a period
constexpr std::size_t most_unknowns_2d = 100'000, most_unknowns_3d = 15'000;

/// Vectors that are orthonormal in the inner product of M, with their products with M.
class MassBasis {
 public:
  /// Take out of v what earlier vectors have; twice, against round-off.
  void make_orthogonal(Eigen::VectorXd& v) const {
    for (int pass = 0; pass < 2; ++pass) {
      for (std::size_t k = 0; k < vectors_.size(); ++k) v -= products_[k].dot(v) * vectors_[k];
    }
  }
  void add(const Eigen::VectorXd& v, const Eigen::VectorXd& product) {
    vectors_.push_back(v);
    products_.push_back(product);
  }
  const Eigen::VectorXd& product(std::size_t k) const { return products_[k]; }
  std::size_t size() const { return vectors_.size(); }

 private:
  std::vector<Eigen::VectorXd> vectors_, products_;
};

/// Uniform motion along unequal axes with noise, which has a share of each mode.
Eigen::VectorXd start_vector(std::size_t num_dofs) {
  std::minstd_rand random(1);
  Eigen::VectorXd v(static_cast<Eigen::Index>(num_dofs));
  for (Eigen::Index i = 0; i < v.size(); ++i) {
    v[i] = 1 + 0.5 * static_cast<double>(random()) / static_cast<double>(std::minstd_rand::max());
  }
  return v;
}

/// The tangent of a step of dt about the state, with inertia.
template <int dim>
BlockMatrix<dim> tangent_about(const StructureStep<dim>& step, const StructureState& state,
                               double dt) {
  const CellIntegrals<dim>& cells = step.equilibrium().cells();
  HistoryStep history;
  std::vector<double> trial, f(step.equilibrium().num_dofs(), 0.0);
  if (state.history) {
    trial.resize(state.history->size());
    history = {.accepted = *state.history, .trial = trial};
  }
  BlockMatrix<dim> K;
  cells.set_pattern(K);
  K.set_zero();
  cells.add_internal(state.motion.u, f, &K, history);
  cells.add_mass(step.equilibrium().scheme().inertia_slope(dt), K);
  const BoundaryConditions<dim>& conditions = step.conditions();
  K.constrain(conditions.constrained_nodes(), conditions.projectors(),
              [](std::int32_t) { return true; });
  return K;
}

/// M and (K + c M)^-1 of the free components.
template <int dim>
class ShiftedProblem {
 public:
  ShiftedProblem(const StructureStep<dim>& step, const StructureState& state, double dt)
      : step_(step), linear_(PETSC_COMM_SELF, dim, {.method = "lu"}) {
    linear_.accept_round_off();
    linear_.set_matrix(tangent_about(step, state, dt));
  }

  Eigen::VectorXd solve(const Eigen::VectorXd& b) {
    std::vector<double> r(b.data(), b.data() + b.size()), x(r.size(), 0.0);
    hold(r);
    linear_.solve(r, x);
    hold(x);
    return Eigen::Map<Eigen::VectorXd>(x.data(), b.size());
  }
  Eigen::VectorXd mass_times(const Eigen::VectorXd& v) const {
    const auto size = static_cast<std::size_t>(v.size());
    const std::vector<double> f = step_.equilibrium().mass_times({v.data(), size});
    return Eigen::Map<const Eigen::VectorXd>(f.data(), v.size());
  }

 private:
  void hold(std::vector<double>& y) const {
    for (const auto dof : step_.conditions().constrained_dofs()) y[dof] = 0;
  }

  const StructureStep<dim>& step_;
  LinearSolver<dim> linear_;
};

}  // namespace

template <int dim>
double first_period(const StructureStep<dim>& step, const StructureState& state, double dt) {
  const Equilibrium<dim>& equilibrium = step.equilibrium();
  ShiftedProblem<dim> problem(step, state, dt);
  MassBasis basis;
  Eigen::MatrixXd T = Eigen::MatrixXd::Zero(num_vectors, num_vectors);
  Eigen::VectorXd v = problem.solve(problem.mass_times(start_vector(equilibrium.num_dofs())));
  double first_size = 0;
  while (basis.size() < num_vectors) {
    basis.make_orthogonal(v);
    Eigen::VectorXd product = problem.mass_times(v);
    const double size = std::sqrt(std::max(0.0, v.dot(product)));
    first_size = std::max(first_size, size);
    if (!(size > 1e-12 * first_size)) break;  // the vectors span all modes that there are
    basis.add(v / size, product / size);
    const auto k = static_cast<Eigen::Index>(basis.size()) - 1;
    v = problem.solve(basis.product(basis.size() - 1));
    for (Eigen::Index j = 0; j <= k; ++j) T(j, k) = T(k, j) = basis.product(j).dot(v);
  }
  const auto n = static_cast<Eigen::Index>(basis.size());
  if (n == 0) return std::numeric_limits<double>::infinity();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> modes(T.topLeftCorner(n, n));
  const double square = 1 / modes.eigenvalues()[n - 1] - equilibrium.scheme().inertia_slope(dt);
  return square > 0 ? 2 * std::numbers::pi / std::sqrt(square)
                    : std::numeric_limits<double>::infinity();
}

template <int dim>
FirstPeriodCheck<dim>::FirstPeriodCheck(const FemSettings<dim>& settings) {
  const NewmarkBossak& scheme = settings.time_integration;
  const std::size_t num_dofs = settings.mesh.nodes.size() * dim;
  due_ = settings.dynamic && scheme.alpha_m == 0 && scheme.alpha_f == 0 && settings.ranks.alone() &&
         num_dofs <= (dim == 2 ? most_unknowns_2d : most_unknowns_3d);
}

template <int dim>
void FirstPeriodCheck<dim>::look_at(const StructureStep<dim>& step, const StructureState& state,
                                    double dt) {
  if (!due_ || step.equilibrium().damped()) return;
  due_ = false;
  double period = 0;
  try {
    period = first_period(step, state, dt);
  } catch (const ConvergenceError&) {
    return;  // the step itself was solved: this is advice alone
  }
  if (period >= fewest_steps * dt) return;
  log::warn(
      "time_integration: found steps of {:.3g} s, {:.2g} a period of the first vibration of the "
      "structure ({:.3g} s), with \"newmark\", which damps nothing: the noise of the shorter "
      "vibrations looks like a result, in reactions first. Allowed: steps up to {:.2g} s; or "
      "\"bossak\", or \"generalized_alpha\" with \"rho_inf\" 0",
      dt, period / dt, period, period / fewest_steps);
}

template double first_period<2>(const StructureStep<2>&, const StructureState&, double);
template double first_period<3>(const StructureStep<3>&, const StructureState&, double);
template class FirstPeriodCheck<2>;
template class FirstPeriodCheck<3>;

}  // namespace gabion::fem
