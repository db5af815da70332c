// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/grid/noise_damping.hpp"

#include <cmath>

#include "mpm_solver/grid/transfer.hpp"

namespace gabion::mpm {

namespace {

// R r, num_nodes x dim.
template <int dim>
std::vector<double> mean_at_nodes(const MaterialPoints<dim>& points,
                                  const PointWeights<dim>& weights, const GridNodes<dim>& nodes,
                                  std::span<const Vector<dim>> r) {
  const double weightless = weightless_mass(nodes);
  std::vector<double> mean = point_forces<dim>(points, weights, nodes, r);
  for (std::size_t k = 0; k < mean.size(); ++k) {
    const double m = nodes.m[k / dim];
    mean[k] *= m > weightless ? 1 / m : 0;
  }
  return mean;
}

// r -= S mean.
template <int dim>
void subtract(const PointWeights<dim>& weights, const GridNodes<dim>& nodes,
              const std::vector<double>& mean, std::vector<Vector<dim>>& r) {
  Eigen::Matrix<double, dim, max_group_nodes<dim>> mean_i;
  for (const CellGroup& group : weights.groups) {
    nodes.gather(weights.nodes_of(group), mean, mean_i.data());
    for (std::int32_t e = group.first; e < group.last; ++e) {
      const double* N = weights.N_of(e);
      const std::uint8_t* local = weights.local_of(e);
      for (int i = 0; i < weights.num_nodes(e); ++i) {
        r[weights.point[e]] -= N[i] * mean_i.col(local[i]);
      }
    }
  }
}

// |grad S mean|^2 of each point.
template <int dim>
std::vector<double> squared_gradients(const PointWeights<dim>& weights, const GridNodes<dim>& nodes,
                                      const std::vector<double>& mean, std::int32_t num_points) {
  std::vector<double> grad2(num_points, 0.0);
  Eigen::Matrix<double, dim, max_group_nodes<dim>> mean_i;
  for (const CellGroup& group : weights.groups) {
    nodes.gather(weights.nodes_of(group), mean, mean_i.data());
    for (std::int32_t e = group.first; e < group.last; ++e) {
      const std::int32_t row = weights.constant_gradient ? group.first : e;
      const Vector<dim>* grad_N = weights.grad_of(row);
      const std::uint8_t* local = weights.local_of(row);
      Eigen::Matrix<double, dim, dim> grad = Eigen::Matrix<double, dim, dim>::Zero();
      for (int i = 0; i < weights.num_nodes(row); ++i) {
        grad += mean_i.col(local[i]) * grad_N[i].transpose();
      }
      grad2[weights.point[e]] = grad.squaredNorm();
    }
  }
  return grad2;
}

}  // namespace

double NoiseDamping::share(double c2, double grad2) const {
  if (c2 == 0) return 0;
  const double h2 = cell_size * cell_size;
  const double flow2 = c2 * inertial_number_of_flow * inertial_number_of_flow;
  const double slow_down = flow2 / (flow2 + h2 * grad2);
  return -std::expm1(-damping * dt / cell_size * std::sqrt(c2) * slow_down);
}

template <int dim>
void damp_noise(const PointWeights<dim>& weights, const GridNodes<dim>& nodes,
                const NoiseDamping& rate, MaterialPoints<dim>& points) {
  std::vector<Vector<dim>> noise = points.v;
  const std::vector<double> v = mean_at_nodes<dim>(points, weights, nodes, noise);
  const std::vector<double> grad2 = squared_gradients<dim>(weights, nodes, v, points.size());
  subtract(weights, nodes, v, noise);
  for (std::int32_t p = 0; p < points.size(); ++p) {
    const double c2 = points.tau[p].norm() * points.V0[p] / points.m[p];
    noise[p] *= rate.share(c2, grad2[p]);
  }
  subtract(weights, nodes, mean_at_nodes<dim>(points, weights, nodes, noise), noise);
  for (std::int32_t p = 0; p < points.size(); ++p) points.v[p] -= noise[p];
}

template void damp_noise<2>(const PointWeights<2>&, const GridNodes<2>&, const NoiseDamping&,
                            MaterialPoints<2>&);
template void damp_noise<3>(const PointWeights<3>&, const GridNodes<3>&, const NoiseDamping&,
                            MaterialPoints<3>&);

}  // namespace gabion::mpm
