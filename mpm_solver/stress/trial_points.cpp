// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/stress/trial_points.hpp"

#include "common/mechanics/tensor_functions.hpp"

namespace gabion::mpm {

namespace {

// @param of_entry  work by volume [J/m^3]
template <int dim, class OfEntry>
PointWork sum_work(const PointWeights<dim>& weights, const MaterialPoints<dim>& points,
                   const OfEntry& of_entry) {
  PointWork work;
  for (std::int32_t e = 0; e < points.size(); ++e) {
    const std::int32_t p = weights.point[e];
    const double by_volume = of_entry(e, p);
    work += {.own = points.V0[p] * by_volume, .summed = weights.volume[e] * by_volume};
  }
  return work;
}

}  // namespace

template <int dim>
PointWork plastic_work(const PointWeights<dim>& weights, const TrialPoints<dim>& trial,
                       const MaterialPoints<dim>& points, std::span<const Symmetric<dim>> tau) {
  return sum_work(weights, points, [&](std::int32_t e, std::int32_t p) {
    const Symmetric<dim> mean_tau = (tau[p] + trial.tau[e]) / 2;
    return contract<dim>(mean_tau, trial.plastic_increment[e]);
  });
}

template <int dim>
PointWork elastic_work(const PointWeights<dim>& weights, const TrialPoints<dim>& trial,
                       const MaterialPoints<dim>& points) {
  return sum_work(weights, points, [&](std::int32_t e, std::int32_t p) {
    return trial.energy[e] - points.energy[p];
  });
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
}

template PointWork plastic_work<2>(const PointWeights<2>&, const TrialPoints<2>&,
                                   const MaterialPoints<2>&, std::span<const Symmetric<2>>);
template PointWork plastic_work<3>(const PointWeights<3>&, const TrialPoints<3>&,
                                   const MaterialPoints<3>&, std::span<const Symmetric<3>>);
template PointWork elastic_work<2>(const PointWeights<2>&, const TrialPoints<2>&,
                                   const MaterialPoints<2>&);
template PointWork elastic_work<3>(const PointWeights<3>&, const TrialPoints<3>&,
                                   const MaterialPoints<3>&);
template void accept_stresses<2>(const PointWeights<2>&, const TrialPoints<2>&, MaterialPoints<2>&);
template void accept_stresses<3>(const PointWeights<3>&, const TrialPoints<3>&, MaterialPoints<3>&);

}  // namespace gabion::mpm
