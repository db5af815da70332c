// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/stress/trial_points.hpp"

namespace gabion::mpm {

template <int dim>
double plastic_work(const PointWeights<dim>& weights, const TrialPoints<dim>& trial,
                    const MaterialPoints<dim>& points, std::span<const Symmetric<dim>> tau) {
  double work = 0;
  for (std::int32_t e = 0; e < points.size(); ++e) {
    const std::int32_t p = weights.point[e];
    work += weights.volume[e] * plastic_density(trial, e, tau[p]);
  }
  return work;
}

template <int dim>
std::span<const Symmetric<dim>> skeleton_stresses(const std::vector<Body<dim>>& bodies,
                                                  const MaterialPoints<dim>& points,
                                                  std::vector<Symmetric<dim>>& room) {
  if (points.water.empty()) return points.tau;
  room = points.tau;
  for (std::int32_t b = 0; b < points.num_bodies(); ++b) {
    for (std::int32_t p = points.body_starts[b]; p < points.body_starts[b + 1]; ++p) {
      room[p].template head<3>().array() += pore_tau<dim>(bodies[b], points, p);
    }
  }
  return room;
}

template <int dim>
double unstored_work(const PointWeights<dim>& weights, const TrialPoints<dim>& trial,
                     const MaterialPoints<dim>& points) {
  double work = 0;
  for (std::int32_t e = 0; e < points.size(); ++e) {
    const std::int32_t p = weights.point[e];
    work += (weights.volume[e] - points.V0[p]) * (trial.energy[e] - points.energy[p]);
  }
  return work;
}

template <int dim>
void accept_stresses(const PointWeights<dim>& weights, const TrialPoints<dim>& trial,
                     MaterialPoints<dim>& points) {
  for (std::int32_t e = 0; e < points.size(); ++e) {
    const std::int32_t p = weights.point[e];
    points.history[p] = trial.history[e];
    points.tau[p] = trial.tau[e];
    points.energy[p] = trial.energy[e];
    points.J[p] *= trial.J_ratio[e];
  }
  for (std::size_t e = 0; e < trial.internal.size(); ++e) {
    points.internal[weights.point[e]] = trial.internal[e];
  }
  for (std::size_t e = 0; e < trial.variables.size(); ++e) {
    points.variables[weights.point[e]] = trial.variables[e];
  }
}

template double plastic_work<2>(const PointWeights<2>&, const TrialPoints<2>&,
                                const MaterialPoints<2>&, std::span<const Symmetric<2>>);
template double plastic_work<3>(const PointWeights<3>&, const TrialPoints<3>&,
                                const MaterialPoints<3>&, std::span<const Symmetric<3>>);
template std::span<const Symmetric<2>> skeleton_stresses<2>(const std::vector<Body<2>>&,
                                                            const MaterialPoints<2>&,
                                                            std::vector<Symmetric<2>>&);
template std::span<const Symmetric<3>> skeleton_stresses<3>(const std::vector<Body<3>>&,
                                                            const MaterialPoints<3>&,
                                                            std::vector<Symmetric<3>>&);
template double unstored_work<2>(const PointWeights<2>&, const TrialPoints<2>&,
                                 const MaterialPoints<2>&);
template double unstored_work<3>(const PointWeights<3>&, const TrialPoints<3>&,
                                 const MaterialPoints<3>&);
template void accept_stresses<2>(const PointWeights<2>&, const TrialPoints<2>&, MaterialPoints<2>&);
template void accept_stresses<3>(const PointWeights<3>&, const TrialPoints<3>&, MaterialPoints<3>&);

}  // namespace gabion::mpm
