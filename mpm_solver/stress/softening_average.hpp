// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>

namespace gabion::mpm {

/// How the strength of a body that softens follows its softening strain kappa: by that of the point
/// and the mean over its surroundings, instead of by a band as wide as the grid makes it (Vermeer,
/// Brinkgreve 1994, over-nonlocal),
///
///     slip = sqrt(3) A l [m kbar + (1 - m) kappa] ,  kbar - l^2 laplace(kbar) = kappa ,
///
/// A l the slip of a surface by the strain in brackets, which is even over its band.
struct SofteningAverage {
  double length = 0;  ///< l [m]; 0: the strength follows kappa alone
  double weight = 2;  ///< m > 1

  bool acts() const { return length > 0; }
  double band_width() const;  ///< of a surface that slips [m]
  double slip_width() const;  ///< A l [m]
  /// d slip / d kappa / sqrt(3) at constant kbar, which a step sees: PointContext::band_width [m].
  double own_width() const { return (1 - weight) * slip_width(); }
};

/// The averages of the bodies of a scene, in their order; empty: none acts.
using SofteningAverages = std::span<const SofteningAverage>;

}  // namespace gabion::mpm
