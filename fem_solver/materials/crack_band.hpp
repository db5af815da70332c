// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cmath>

#include "common/mechanics/tensor.hpp"

namespace gabion::fem {

/// Widths of the band of cells in which a crack lies: bricks are as wide as their edges through the
/// centre, simplices as the brick that they are a part of, (dim! V)^(1/dim).
template <int dim>
struct CrackBand {
  Matrix<dim> edges = Matrix<dim>::Zero();  ///< as columns [m]; zero: simplices
  double mean = 0;  ///< of simplices, and of the other axis in the plane [m]

  /// Length of the edge whose direction is nearest to the normal n of a crack [m]. It jumps with n,
  /// so that it adds nothing to derivatives; zero: normal to the plane.
  double width(const Vector<dim>& n) const {
    int nearest = -1;
    double most = 0;
    for (int i = 0; i < dim; ++i) {
      const double length = edges.col(i).norm();
      if (!(std::abs(edges.col(i).dot(n)) > most * length)) continue;
      most = std::abs(edges.col(i).dot(n)) / length;
      nearest = i;
    }
    return nearest >= 0 ? edges.col(nearest).norm() : mean;
  }
  double largest() const { return std::max(mean, edges.colwise().norm().maxCoeff()); }
};

}  // namespace gabion::fem
