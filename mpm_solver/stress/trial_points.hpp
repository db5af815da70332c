// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <vector>

#include "common/mechanics/tensor_functions.hpp"
#include "mpm_solver/grid/basis.hpp"

namespace gabion::mpm {

/// State of the material points at the end of a step that is being solved, by entry of
/// PointWeights.
template <int dim>
struct TrialPoints {
  std::vector<MaterialState<dim>> history;
  std::vector<Symmetric<dim>> tau;
  std::vector<double> J_ratio;  ///< volume ratio of the step
  std::vector<double> energy;
  std::vector<Symmetric<dim>> plastic_increment;  ///< of StressUpdate
  std::vector<YieldRegion> region;
  std::vector<InternalState> internal;    ///< empty where MaterialPoints::internal is
  std::vector<StateVariables> variables;  ///< empty where MaterialPoints::variables is
  std::vector<double> pore_tau;  ///< J p of the pore water; empty where no body has any [Pa]
  /// Room for the points of a rank.
  void resize(const MaterialPoints<dim>& points) {
    const std::size_t n = points.x.size();
    history.resize(n);
    tau.resize(n);
    J_ratio.resize(n);
    energy.resize(n);
    plastic_increment.resize(n);
    region.resize(n);
    // Only laws that remember something set theirs.
    internal.assign(points.internal.size(), InternalState::Zero());
    variables.assign(points.variables.size(), StateVariables::Zero());
    if (!pore_tau.empty()) pore_tau.assign(n, 0.0);
  }
  /// Kirchhoff stress of the skeleton [Pa].
  Symmetric<dim> effective_tau(std::int32_t e) const {
    Symmetric<dim> stress = tau[e];
    if (!pore_tau.empty()) stress.template head<3>().array() += pore_tau[e];
    return stress;
  }
};

/// Plastic work of this rank's points on their path to the trial state [J].
/// @param tau  stresses of the skeleton where the path began, one a point [Pa]
template <int dim>
double plastic_work(const PointWeights<dim>& weights, const TrialPoints<dim>& trial,
                    const MaterialPoints<dim>& points, std::span<const Symmetric<dim>> tau);

/// Plastic work of one entry on its path to the trial state, over PointWeights::volume [J/m^3].
/// @param tau  stress of the skeleton where the path began [Pa]
template <int dim>
double plastic_density(const TrialPoints<dim>& trial, std::int32_t entry,
                       const Symmetric<dim>& tau) {
  const Symmetric<dim> mean_tau = (tau + trial.effective_tau(entry)) / 2;
  return contract<dim>(mean_tau, trial.plastic_increment[entry]);
}

/// Stresses of the skeleton of the points in the accepted state [Pa]: their own, or in `room` where
/// a body has pore water.
template <int dim>
std::span<const Symmetric<dim>> skeleton_stresses(const std::vector<Body<dim>>& bodies,
                                                  const MaterialPoints<dim>& points,
                                                  std::vector<Symmetric<dim>>& room);

/// Plastic work from the accepted state.
template <int dim>
double plastic_work(const PointWeights<dim>& weights, const TrialPoints<dim>& trial,
                    const MaterialPoints<dim>& points, const std::vector<Body<dim>>& bodies) {
  std::vector<Symmetric<dim>> room;
  return plastic_work<dim>(weights, trial, points, skeleton_stresses<dim>(bodies, points, room));
}

/// Work of forces over the volumes of PointWeights on the path from the accepted state to the trial
/// state that turns into neither heat nor elastic energy of this rank's points [J].
template <int dim>
double unstored_work(const PointWeights<dim>& weights, const TrialPoints<dim>& trial,
                     const MaterialPoints<dim>& points);

/// Give the points stresses and memory of the trial state.
template <int dim>
void accept_stresses(const PointWeights<dim>& weights, const TrialPoints<dim>& trial,
                     MaterialPoints<dim>& points);

}  // namespace gabion::mpm
