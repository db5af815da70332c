// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <vector>

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
  std::vector<InternalState> internal;  ///< empty where MaterialPoints::internal is
  /// Room for the points of a rank.
  void resize(const MaterialPoints<dim>& points) {
    const std::size_t n = points.x.size();
    history.resize(n);
    tau.resize(n);
    J_ratio.resize(n);
    energy.resize(n);
    plastic_increment.resize(n);
    region.resize(n);
    internal.resize(points.internal.size());
  }
};

/// Plastic work of this rank's points on their way to the trial state [J].
/// @param tau  stresses where the way began, one a point [Pa]
template <int dim>
double plastic_work(const PointWeights<dim>& weights, const TrialPoints<dim>& trial,
                    const MaterialPoints<dim>& points, std::span<const Symmetric<dim>> tau);

/// What forces over the volumes of PointWeights do on the way from the accepted state to the trial
/// state that turns into neither heat nor elastic energy of this rank's points [J].
template <int dim>
double unstored_work(const PointWeights<dim>& weights, const TrialPoints<dim>& trial,
                     const MaterialPoints<dim>& points);

/// Make stresses and memory of the trial state those of the points.
template <int dim>
void accept_stresses(const PointWeights<dim>& weights, const TrialPoints<dim>& trial,
                     MaterialPoints<dim>& points);

}  // namespace gabion::mpm
