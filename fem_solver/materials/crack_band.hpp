// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>

#include "common/mechanics/tensor.hpp"

namespace gabion::fem {

/// Widths of the band of cells in which a crack lies: bricks are as wide as their edges through the
/// centre, simplices as the brick that they are a part of, (dim! V)^(1/dim).
template <int dim>
struct CrackBand {
  Matrix<dim> edges = Matrix<dim>::Zero();  ///< as columns [m]; zero: simplices
  double mean = 0;  ///< of simplices, and of the other axis in the plane [m]

  /// Length of the edge that the normal n of a crack follows most [m]. It jumps with n, so that it
  /// adds nothing to derivatives; zero: normal to the plane.
  double width(const Vector<dim>& n) const {
    const Vector<dim> along = (edges.transpose() * n).cwiseAbs();
    int widest = 0;
    for (int i = 1; i < dim; ++i) {
      if (along[i] > along[widest]) widest = i;
    }
    return along[widest] > 0 ? edges.col(widest).norm() : mean;
  }
  double largest() const { return std::max(mean, edges.colwise().norm().maxCoeff()); }
};

}  // namespace gabion::fem
