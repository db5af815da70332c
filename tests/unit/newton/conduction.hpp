// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "common/mechanics/newton/newton.hpp"
#include "common/mechanics/norm.hpp"
#include "tests/support/mpi_main.hpp"

namespace gabion::test {

/// Steady conduction of `fields` quantities u in the unit square, whose conductivity is 1 + c u.
/// Kirchhoff's transform makes it linear:
///
///     - Laplace theta = q ,   theta = u + c u^2 / 2 ,   r_a = h^2 q - sum_b L_ab theta(u_b)
///
/// with the bilinear L of square cells, whose stencil of nine nodes is exact for the
///
///     theta = (1 + k) (1 + x y + x^2) ,   q = -2 (1 + k)          of field k = 0, 1, ...
///
/// u is prescribed on the rim. Each rank evaluates all of r and its share of the matrix.
template <int fields>
class Conduction : public NewtonProblem<fields> {
 public:
  explicit Conduction(double slope) : c(slope) {}

  static constexpr int cells_along = 6;
  static constexpr int nodes_along = cells_along + 1;
  static constexpr double h = 1.0 / cells_along;
  double c;

  static constexpr int num_nodes() { return nodes_along * nodes_along; }
  static constexpr std::size_t num_unknowns() { return std::size_t{fields} * num_nodes(); }
  double increment_scale() const override { return 1; }

  double exact(int node, int k) const {
    const double x = h * (node % nodes_along), y = h * (node / nodes_along);
    const double theta = (1 + k) * (1 + x * y + x * x);
    return c == 0 ? theta : (std::sqrt(1 + 2 * c * theta) - 1) / c;
  }

  /// The solution on the rim, zero inside.
  std::vector<double> guess() const {
    std::vector<double> u(num_unknowns(), 0.0);
    for (const int i : rim())
      for (int k = 0; k < fields; ++k) u[i * fields + k] = exact(i, k);
    return u;
  }

  static void set_pattern(BlockMatrix<fields>& K) {
    std::vector<std::int32_t> offsets{0}, nodes;
    for (int cell = 0; cell < cells_along * cells_along; ++cell) {
      const auto corners = corners_of(cell);
      nodes.insert(nodes.end(), corners.begin(), corners.end());
      offsets.push_back(static_cast<std::int32_t>(nodes.size()));
    }
    K.set_pattern(num_nodes(), offsets, nodes);
  }

  Evaluation evaluate(std::span<const double> u, std::span<double> r,
                      BlockMatrix<fields>* K) override {
    for (std::size_t i = 0; i < r.size(); ++i) r[i] = -2 * (1.0 + i % fields) * h * h;
    if (K) K->set_zero();
    std::vector<double> flux(r.size(), 0.0);
    for (int cell = 0; cell < cells_along * cells_along; ++cell) {
      add_flux(cell, u, flux);
      if (K && cell % size() == rank()) add_slopes(cell, u, *K);
    }
    for (std::size_t i = 0; i < r.size(); ++i) r[i] -= flux[i];
    const std::vector<std::int32_t> held = rim();
    for (const int i : held) std::fill_n(r.begin() + i * fields, fields, 0.0);
    if (K) {
      const std::vector<NodeBlock<fields>> none(held.size(), NodeBlock<fields>::Zero());
      K->constrain(held, none, [](std::int32_t) { return rank() == 0; });
    }
    Evaluation result;
    result.force_scale = norm_of(flux);
    return result;
  }

 private:
  static std::array<std::int32_t, 4> corners_of(int cell) {
    const int first = cell / cells_along * nodes_along + cell % cells_along;
    return {first, first + 1, first + nodes_along + 1, first + nodes_along};
  }

  static std::vector<std::int32_t> rim() {
    std::vector<std::int32_t> nodes;
    for (int i = 0; i < num_nodes(); ++i) {
      const int column = i % nodes_along, row = i / nodes_along;
      if (std::min(column, row) == 0 || std::max(column, row) == cells_along) nodes.push_back(i);
    }
    return nodes;
  }

  /// Integral of grad N_a . grad N_b over a square.
  static double laplace(int a, int b) {
    if (a == b) return 2.0 / 3;
    return (a + b) % 2 == 0 ? -1.0 / 3 : -1.0 / 6;
  }

  void add_flux(int cell, std::span<const double> u, std::vector<double>& flux) const {
    const auto nodes = corners_of(cell);
    for (int a = 0; a < 4; ++a) {
      for (int b = 0; b < 4; ++b) {
        for (int k = 0; k < fields; ++k) {
          const double u_b = u[nodes[b] * fields + k];
          flux[nodes[a] * fields + k] += laplace(a, b) * (u_b + c * u_b * u_b / 2);
        }
      }
    }
  }

  void add_slopes(int cell, std::span<const double> u, BlockMatrix<fields>& K) const {
    const auto nodes = corners_of(cell);
    constexpr int width = 4 * fields;
    std::vector<double> slopes(width * width, 0.0);
    for (int a = 0; a < 4; ++a) {
      for (int b = 0; b < 4; ++b) {
        for (int k = 0; k < fields; ++k) {
          slopes[(a * fields + k) * width + b * fields + k] =
              laplace(a, b) * (1 + c * u[nodes[b] * fields + k]);
        }
      }
    }
    K.add_cell(cell, slopes.data());
  }
};

}  // namespace gabion::test
