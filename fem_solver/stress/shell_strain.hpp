// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "common/mechanics/elements/shape_functions.hpp"
#include "fem_solver/materials/green_stress.hpp"

namespace gabion::fem {

/// Enhancing modes of a solid shell.
inline constexpr int num_shell_modes = 7;
/// Enhancement of the strain at a point by each mode, without dimension.
using ShellModes = Eigen::Matrix<double, strain_size<3>, num_shell_modes>;

/// Points across the thickness: those of a Gauss rule, and of one in each half for laws that yield,
/// which gives the fully plastic moment exactly.
inline constexpr int elastic_points_across = 2, yielding_points_across = 6;

/// Rule of all solid shells whose thickness lies along one reference axis: the places of the
/// reference cell from which each quadrature point takes each component of the strain
/// (docs/theory/structure.md, (T38)).
struct ShellRule {
  static constexpr int num_nodes = 8, num_terms = 11;
  static constexpr int num_ties = 8;  ///< places before those of the points themselves
  static constexpr int max_points = 4 * yielding_points_across;
  static constexpr int max_places = num_ties + max_points;

  /// A share of a covariant component of the strain at a place.
  struct Term {
    int i = 0, j = 0;  ///< of e_ij, reference axes
    int place = 0;
    double share = 1;
  };

  std::vector<QuadraturePoint<3>> points;
  std::vector<std::array<Vector<3>, num_nodes>> slopes;  ///< places: dN_a/dxi
  std::vector<std::array<Term, num_terms>> terms;        ///< points

  /// @param axis    along the thickness
  /// @param across  points: elastic_points_across or yielding_points_across
  ShellRule(int axis, int across);
};

/// Shape of a solid shell without stress, for each point of its rule.
struct ShellShape {
  std::array<Vector<3>, ShellRule::num_nodes> x;
  std::vector<StrainMatrix<3>> axes;  ///< StrainVector of e_ij to that on the axes of space
  std::vector<ShellModes> modes;
};

/// @param x  of the nodes
/// @throws   nothing: the caller has checked Jacobians
ShellShape shell_shape(const ShellRule& rule, int axis, std::span<const Vector<3>> x);

/// Solid shells of a block.
struct ShellCells {
  std::vector<ShellRule> rules;  ///< of each axis; empty: not shells
  std::vector<int> axes;         ///< cells: along the thickness
  std::vector<ShellShape> shapes;

  const ShellRule& rule(std::size_t c) const { return rules[axes[c]]; }
};

}  // namespace gabion::fem
