// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <random>
#include <vector>

#include "common/mechanics/elements/shape_functions.hpp"

namespace gabion::test {

/// Nodes of the reference cell.
template <int dim>
std::vector<Vector<dim>> reference_nodes(CellType type) {
  const int corner[8][3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0},
                            {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}};
  std::vector<Vector<dim>> nodes(num_nodes(type), Vector<dim>::Zero());
  for (int a = 0; a < num_nodes(type); ++a) {
    for (int i = 0; i < dim; ++i) {
      nodes[a][i] = is_simplex(type) ? (a == i + 1 ? 1.0 : 0.0) : 2.0 * corner[a][i] - 1.0;
    }
  }
  return nodes;
}

template <int dim>
bool inside_reference(CellType type, const Vector<dim>& xi) {
  if (is_simplex(type)) return xi.minCoeff() > 0 && xi.sum() < 1;
  return xi.cwiseAbs().maxCoeff() < 1;
}

/// Points all over the inside of the reference cell.
template <int dim>
std::vector<Vector<dim>> sample_points(CellType type, int count = 50) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> uniform(-1, 1);
  std::vector<Vector<dim>> points;
  while (static_cast<int>(points.size()) < count) {
    Vector<dim> xi;
    for (int i = 0; i < dim; ++i) xi[i] = uniform(random);
    if (inside_reference<dim>(type, xi)) points.push_back(xi);
  }
  return points;
}

}  // namespace gabion::test
