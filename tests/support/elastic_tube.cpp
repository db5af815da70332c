// SPDX-License-Identifier: BSD-3-Clause
#include "tests/support/elastic_tube.hpp"

#include <algorithm>
#include <cmath>

namespace gabion::test {

namespace {

constexpr int n = Tube::num_nodes;
constexpr double pi = 3.14159265358979323846;

double inflow(double t) {
  return 10 + 3 * std::sin(10 * pi * t);
}

/// A matrix with entries at most `width` beside its diagonal; solves by Gauss with row exchanges,
/// which fill up to 2 width above it.
class Banded {
 public:
  explicit Banded(int size) : rows_(Eigen::MatrixXd::Zero(size, 3 * width + 1)) {}
  void clear() { rows_.setZero(); }
  double& operator()(int i, int j) { return rows_(i, j - i + width); }

  /// @returns whether no pivot was zero
  bool solve(Eigen::VectorXd& b) {
    const int size = static_cast<int>(b.size());
    for (int k = 0; k < size; ++k) {
      const int below = std::min(size - 1, k + width), right = std::min(size - 1, k + 2 * width);
      int pivot = k;
      for (int i = k + 1; i <= below; ++i) {
        if (std::abs((*this)(i, k)) > std::abs((*this)(pivot, k))) pivot = i;
      }
      if ((*this)(pivot, k) == 0) return false;
      for (int j = k; j <= right && pivot != k; ++j) std::swap((*this)(k, j), (*this)(pivot, j));
      std::swap(b(k), b(pivot));
      for (int i = k + 1; i <= below; ++i) {
        const double factor = (*this)(i, k) / (*this)(k, k);
        for (int j = k; j <= right; ++j) (*this)(i, j) -= factor * (*this)(k, j);
        b(i) -= factor * b(k);
      }
    }
    for (int k = size - 1; k >= 0; --k) {
      for (int j = k + 1; j <= std::min(size - 1, k + 2 * width); ++j) b(k) -= (*this)(k, j) * b(j);
      b(k) /= (*this)(k, k);
    }
    return true;
  }

 private:
  static constexpr int width = 4;
  Eigen::MatrixXd rows_;  // (i, j) at (i, j - i + width)
};

/// Equations of one step; unknowns v_0, p_0, v_1, p_1, ...
class FlowEquations {
 public:
  FlowEquations(const Eigen::VectorXd& a_old, const Eigen::VectorXd& v_old, double p_end_old,
                const Eigen::VectorXd& a, double t, double dt)
      : a_old_(a_old), v_old_(v_old), p_end_old_(p_end_old), a_(a), t_(t), dt_(dt) {}

  void assemble(const Eigen::VectorXd& v, const Eigen::VectorXd& p) {
    residual = Eigen::VectorXd::Zero(2 * n);
    jacobian.clear();
    for (int i = 1; i + 1 < n; ++i) add_cell(v, p, i);
    add_ends(v, p);
  }

  Eigen::VectorXd residual;
  Banded jacobian{2 * n};

 private:
  static int v_row(int i) { return 2 * i; }
  static int p_row(int i) { return 2 * i + 1; }
  void slope(int row, int column, double value) { jacobian(row, column) += value; }

  void add_cell(const Eigen::VectorXd& v, const Eigen::VectorXd& p, int i) {
    const double volume_rate = Tube::length / (n - 1) / dt_;
    const int momentum = v_row(i), mass = p_row(i);
    residual(momentum) = (a_(i) * v(i) - a_old_(i) * v_old_(i)) * volume_rate;
    residual(mass) = (a_(i) - a_old_(i)) * volume_rate;
    slope(momentum, v_row(i), a_(i) * volume_rate);
    for (const int out : {-1, 1}) {  // faces towards i - 1 and i + 1
      const int left = out < 0 ? i - 1 : i;
      const double half_a = 0.25 * (a_(left) + a_(left + 1)) * out;
      const double v2 = v(left) + v(left + 1);
      residual(mass) += half_a * v2;
      slope(mass, v_row(left), half_a);
      slope(mass, v_row(left + 1), half_a);
      residual(momentum) += half_a * v2 * v(left);  // it carries the momentum of its upwind node
      slope(momentum, v_row(left), half_a * (v2 + v(left)));
      slope(momentum, v_row(left + 1), half_a * v(left));
      const double jump = p(left + 1) - p(left);
      residual(momentum) += std::abs(half_a) * jump;
      slope(momentum, p_row(left + 1), std::abs(half_a));
      slope(momentum, p_row(left), -std::abs(half_a));
    }
  }

  void add_ends(const Eigen::VectorXd& v, const Eigen::VectorXd& p) {
    const int last = n - 1;
    residual(v_row(0)) = v(0) - inflow(t_ + dt_);
    slope(v_row(0), v_row(0), 1);
    extrapolate(p_row(0), p_row(0), p_row(1), p_row(2), p(0), p(1), p(2));
    extrapolate(v_row(last), v_row(last), v_row(last - 1), v_row(last - 2), v(last), v(last - 1),
                v(last - 2));
    const double speed =
        std::sqrt(Tube::wave_speed_2 - p_end_old_ / 2) - (v(last) - v_old_(last)) / 4;
    residual(p_row(last)) = p(last) - 2 * (Tube::wave_speed_2 - speed * speed);
    slope(p_row(last), p_row(last), 1);
    slope(p_row(last), v_row(last), -speed);
  }

  void extrapolate(int row, int c0, int c1, int c2, double y0, double y1, double y2) {
    residual(row) = y0 - 2 * y1 + y2;
    slope(row, c0, 1);
    slope(row, c1, -2);
    slope(row, c2, 1);
  }

  const Eigen::VectorXd& a_old_;
  const Eigen::VectorXd& v_old_;
  double p_end_old_;
  const Eigen::VectorXd& a_;
  double t_;
  double dt_;
};

}  // namespace

InterfaceMesh Tube::mesh() {
  InterfaceMesh mesh;
  mesh.name = "wall";
  mesh.dim = 2;
  mesh.vertices_per_facet = 0;
  for (int i = 0; i < n; ++i) {
    mesh.coordinates.insert(mesh.coordinates.end(), {length * i / (n - 1), 0});
  }
  return mesh;
}

TubeFlow::TubeFlow()
    : a_(Eigen::VectorXd::Ones(n)),
      v_(Eigen::VectorXd::Constant(n, inflow(0))),
      p_(Eigen::VectorXd::Zero(n)) {}

StepReport TubeFlow::solve_step(const StepRequest& request, const InterfaceValues& received,
                                InterfaceValues& sent) {
  const std::vector<double>& growth = received.at("wall");
  a_trial_.resize(n);
  for (int i = 0; i < n; ++i) a_trial_(i) = 1 + growth[std::size_t(2 * i)];
  v_trial_ = v_;
  p_trial_ = p_;
  FlowEquations equations(a_, v_, p_(n - 1), a_trial_, request.time, request.dt);
  StepReport report;
  for (;; ++report.newton_iterations) {
    equations.assemble(v_trial_, p_trial_);
    const double size = std::sqrt(v_trial_.squaredNorm() + p_trial_.squaredNorm());
    const double error = equations.residual.norm() / size;
    if (error < 1e-13 && report.newton_iterations > 0) break;
    if (!std::isfinite(error) || report.newton_iterations == 50) {
      throw ConvergenceError("the flow in the tube does not converge");
    }
    Eigen::VectorXd change = equations.residual;
    if (!equations.jacobian.solve(change))
      throw ConvergenceError("the flow's Jacobian is singular");
    for (int i = 0; i < n; ++i) {
      v_trial_(i) -= change(2 * i);
      p_trial_(i) -= change(2 * i + 1);
    }
  }
  std::vector<double>& pressure = sent["wall"];
  pressure.assign(2 * n, 0);
  for (int i = 0; i < n; ++i) pressure[std::size_t(2 * i)] = p_trial_(i);
  return report;
}

AcceptReport TubeFlow::accept_step(const StepRequest&, bool) {
  a_ = a_trial_;
  v_ = v_trial_;
  p_ = p_trial_;
  AcceptReport report;
  report.probes = probes();
  return report;
}

StepReport TubeWall::solve_step(const StepRequest&, const InterfaceValues& received,
                                InterfaceValues& sent) {
  const std::vector<double>& pressure = received.at("wall");
  std::vector<double>& growth = sent["wall"];
  growth.assign(2 * n, 0);
  for (std::size_t i = 0; i < std::size_t(n); ++i) {
    const double stretch = 2 * Tube::wave_speed_2 / (2 * Tube::wave_speed_2 - pressure[2 * i]);
    growth[2 * i] = stretch * stretch - 1;
  }
  growth_mid_trial_ = growth[std::size_t(2 * (n / 2))];
  return {};
}

AcceptReport TubeWall::accept_step(const StepRequest&, bool) {
  growth_mid_ = growth_mid_trial_;
  AcceptReport report;
  report.probes = probes();
  return report;
}

}  // namespace gabion::test
