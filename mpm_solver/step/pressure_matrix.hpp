// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <vector>

#include "mpm_solver/grid/point_inertia.hpp"
#include "mpm_solver/step/pressure_solver.hpp"
#include "mpm_solver/stress/seepage_forces.hpp"
#include "mpm_solver/walls/wall_conditions.hpp"

namespace gabion::mpm {

/// The matrix of the pressures of a fractional step (W23),
///
///     A = S + dt^2 N^T M N ,  M_gh = sum_ij c_gi Q_i W_ij Q_j c_hj ,
///
/// of the shares N of the nodes in the pressures that push at the skeleton, of groups (F-bar) or of
/// points, and the forces c of those pressures by them [m^2], at the start of the step; Q of the
/// walls, W of PointInertia. Its products take M, which is small, and its preconditioner is what A
/// is on the pattern of S: A couples nodes over three cells, but falls off within one.
template <int dim>
class PressureMatrix {
 public:
  struct Parts {
    const StressParts<dim>& stress;
    const WallConditions<dim>& walls;
    const PointInertia<dim>& inertia;
    bool averages;  ///< groups push
  };
  /// @param K  its pattern, and S: less the last value of each block
  PressureMatrix(const Parts& parts, const BlockMatrix<dim + 1>& K, double dt);

  /// Values of S [m^3/Pa], to be changed in place.
  std::vector<double>& storage() { return S_.values; }
  /// S with outlets that let water pass now, or no more.
  void change(const StressParts<dim>& parts, std::span<const OutletChange> outlets);
  /// r = A q, in the nodes that are not held; r = q in those. @pre q = 0 in held nodes
  void multiply(std::span<const double> q, std::span<const char> held, std::span<double> r) const;
  /// f += sum of c N q: what a change of the pressures adds to the forces, num_nodes x dim.
  void add_forces(std::span<const double> q, std::span<double> f) const;
  /// A on the pattern of S; rows and columns of held nodes are those of the unit matrix.
  /// @param lump  add the sizes of what is left out to the diagonal: such a matrix is always
  ///              positive definite
  SparseRows near(std::span<const char> held, bool lump) const;

 private:
  void find_responses(const Parts& parts);
  struct Pushes {
    std::vector<std::int32_t> starts, nodes;  // nodes of push g: nodes[starts[g] ..]
    std::vector<double> N;
    std::vector<Vector<dim>> c;
  };
  void list_pushes(const Parts& parts);

  Pushes pushes_;
  SparseRows S_;
  SparseRows M_;  // times dt^2
};

}  // namespace gabion::mpm
