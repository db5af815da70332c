// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "mpm_solver/contact/surface_features.hpp"

namespace gabion::mpm {

/// A contact goes on in the next step where its normal turned by less than 60 degrees.
constexpr double same_normal = 0.5;

/// A place with which a point was in contact when the step began.
template <int dim>
struct KnownContact {
  std::int32_t owner = 0;  ///< surface
  Vector<dim> normal = Vector<dim>::Zero();
};

/// The surface around a point that is in front of it when the step begins: the point is in front of
/// the nearest simplex with which it was in contact.
template <int dim>
struct FrontView {
  const FacingSurface<dim>& surface;           ///< `facing`: see front_reach, faced_near
  std::span<const SimplexBounds<dim>> bounds;  ///< at the start of the step
  std::span<const Neighbours<dim>> neighbours;
  std::span<const char> at_rest;  ///< of each owner: 1 if it is in this step
  std::span<const KnownContact<dim>> touched;
  double nearer = 0;  ///< at the end of its displacement path the point is nearer to the simplices
                      ///< that it faces by this [m]
  double around = 0;  ///< look at simplices as far as this, if that is farther than needed [m]
  double margin = 0;  ///< simplices that are farther at the start do not count [m]
};

/// The simplices near a place when the step begins.
template <int dim>
struct NearPlace {
  Vector<dim> place = Vector<dim>::Zero();
  double distance = 0;                      ///< [m]
  std::span<const std::int32_t> simplices;  ///< ascending: all within that distance, and others
};

/// Simplices near a place that a point at x faces when the step begins.
/// @param[out] list  by ascending simplex; distance: of the place, or less
template <int dim>
void faced_near(const FrontView<dim>& view, const Vector<dim>& x, const NearPlace<dim>& near,
                std::vector<FacingSimplex>& list);

/// Radius around the end of the displacement path within which `facing` has to have all simplices
/// [m], unless `around` is more.
template <int dim>
double front_reach(const FacingSurface<dim>& surface, const FeatureReach& reach, double path);

/// The features of find_features, equal to the bit, from fewer simplices.
/// @param features  cleared first
/// @returns false: the point may have come behind the surface, or what it was in contact with is
///          farther away than the search goes; call find_features then
template <int dim>
bool features_in_front(const FrontView<dim>& view, const Vector<dim>& x, const Vector<dim>& y,
                       const FeatureReach& reach, std::vector<SurfaceFeature<dim>>& features);

}  // namespace gabion::mpm
