// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/stress/nonlocal_slip.hpp"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "common/base/error.hpp"

namespace gabion::mpm {

namespace {

constexpr double tolerance = 1e-10;  // of the residual, in the norm of the preconditioner
constexpr int most_iterations = 1000;

/// Helmholtz's operator on the nodes of one body, without a matrix.
template <int dim>
class BodyAverage {
 public:
  BodyAverage(std::int32_t body, const PointWeights<dim>& weights, const GridNodes<dim>& nodes,
              const MaterialPoints<dim>& points)
      : body_(body), weights_(weights), nodes_(nodes), points_(points) {}

  /// visit(entry, values of the entry's nodes in the nodal fields)
  template <class Visit>
  void for_each_entry(const Visit& visit) const {
    std::int32_t active[max_group_nodes<dim>];
    for (std::int32_t g = weights_.body_groups[body_]; g < weights_.body_groups[body_ + 1]; ++g) {
      const CellGroup& group = weights_.groups[g];
      nodes_.list_active(weights_.nodes_of(group), active);
      for (std::int32_t e = group.first; e < group.last; ++e) {
        visit(e, [&, local = weights_.local_of(e)](int i) { return active[local[i]]; });
      }
    }
  }
  double volume(std::int32_t e) const {
    const std::int32_t p = weights_.point[e];
    return points_.V0[p] * points_.J[p];
  }

  /// Set masses, diagonal and right-hand side. @param l  length [m]
  void assemble(double l) {
    l_squared_ = l * l;
    M_.assign(nodes_.size(), 0.0);
    b_ = diagonal_ = M_;
    for_each_entry([&](std::int32_t e, const auto& node) {
      const double V = volume(e), kappa = points_.internal[weights_.point[e]][0];
      for (int i = 0; i < weights_.num_nodes(e); ++i) {
        const double N = weights_.N_of(e)[i];
        M_[node(i)] += V * N;
        b_[node(i)] += V * N * kappa;
        diagonal_[node(i)] += V * (N + l_squared_ * weights_.grad_of(e)[i].squaredNorm());
      }
    });
    nodes_.shared.sum(M_, 1);
    nodes_.shared.sum(b_, 1);
    nodes_.shared.sum(diagonal_, 1);
  }

  void apply(std::span<const double> x, std::vector<double>& y) const {
    y.assign(x.size(), 0.0);
    for_each_entry([&](std::int32_t e, const auto& node) {
      const Vector<dim>* grad = weights_.grad_of(e);
      Vector<dim> flux = Vector<dim>::Zero();
      for (int i = 0; i < weights_.num_nodes(e); ++i) flux += x[node(i)] * grad[i];
      flux *= l_squared_ * volume(e);
      for (int i = 0; i < weights_.num_nodes(e); ++i) y[node(i)] += flux.dot(grad[i]);
    });
    nodes_.shared.sum(y, 1);
    for (std::size_t i = 0; i < y.size(); ++i) y[i] += M_[i] * x[i];
  }

  /// Conjugate gradients with the diagonal. @returns kbar at the nodes
  std::vector<double> solve() const {
    const std::size_t n = b_.size();
    std::vector<double> x(n, 0.0), r, z(n), d, q;
    for (std::size_t i = 0; i < n; ++i) x[i] = M_[i] > 0 ? b_[i] / M_[i] : 0;
    const double limit = tolerance * std::sqrt(precondition(b_, z));
    apply(x, r);
    for (std::size_t i = 0; i < n; ++i) r[i] = b_[i] - r[i];
    double rz = precondition(r, z);
    d = z;
    for (int k = 0; k < most_iterations; ++k) {
      if (std::sqrt(rz) <= limit) return x;
      apply(d, q);
      const double step = rz / nodes_.shared.dot(d, q);
      for (std::size_t i = 0; i < n; ++i) {
        x[i] += step * d[i];
        r[i] -= step * q[i];
      }
      const double before = rz;
      rz = precondition(r, z);
      for (std::size_t i = 0; i < n; ++i) d[i] = z[i] + rz / before * d[i];
    }
    throw ConvergenceError(
        fmt::format("the mean of the softening strain was not found in {} iterations",
                    most_iterations),
        "softening_average");
  }

 private:
  // z = r / diagonal, and r . z.
  double precondition(std::span<const double> r, std::vector<double>& z) const {
    for (std::size_t i = 0; i < z.size(); ++i) z[i] = diagonal_[i] > 0 ? r[i] / diagonal_[i] : 0;
    return nodes_.shared.dot(r, z);
  }

  std::int32_t body_;
  const PointWeights<dim>& weights_;
  const GridNodes<dim>& nodes_;
  const MaterialPoints<dim>& points_;
  double l_squared_ = 0;
  std::vector<double> M_, b_, diagonal_;
};

// Half the width of the band by l.
double half_width(double m) {
  const double root = std::sqrt(m - 1);
  return root * (std::numbers::pi - std::atan(1 / root));
}

}  // namespace

double SofteningAverage::band_width() const {
  return 2 * half_width(weight) * length;
}

double SofteningAverage::slip_width() const {
  return band_width() + 2 * length;
}

template <int dim>
void set_nonlocal_slip(SofteningAverages averages, const PointWeights<dim>& weights,
                       const GridNodes<dim>& nodes, MaterialPoints<dim>& points) {
  for (std::size_t b = 0; b < averages.size(); ++b) {
    const SofteningAverage& average = averages[b];
    if (!average.acts()) continue;
    BodyAverage<dim> body(static_cast<std::int32_t>(b), weights, nodes, points);
    body.assemble(average.length);
    const std::vector<double> kbar = body.solve();
    const double slip = std::numbers::sqrt3 * average.slip_width(), m = average.weight;
    body.for_each_entry([&](std::int32_t e, const auto& node) {
      double mean = 0;
      for (int i = 0; i < weights.num_nodes(e); ++i) mean += weights.N_of(e)[i] * kbar[node(i)];
      InternalState& internal = points.internal[weights.point[e]];
      internal[1] = slip * (m * mean + (1 - m) * internal[0]);
    });
  }
}

template void set_nonlocal_slip<2>(SofteningAverages, const PointWeights<2>&, const GridNodes<2>&,
                                   MaterialPoints<2>&);
template void set_nonlocal_slip<3>(SofteningAverages, const PointWeights<3>&, const GridNodes<3>&,
                                   MaterialPoints<3>&);

}  // namespace gabion::mpm
