// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "common/base/require.hpp"
#include "mpm_solver/stress/internal_forces.hpp"
#include "tests/unit/mpm/soil_patch.hpp"

namespace gabion::test {

/// Material points in a unit box whose grid nodes are moved as a test says, without inertia.
template <int dim>
struct DrivenBlock {
  SoilPatch<dim> soil;
  std::vector<double> f_int;  ///< of the last move, active nodes x dim [N]

  /// @param low, high  corners of the body, laid out with `cells` cells in each direction
  DrivenBlock(CellType type, int grid_cells, const MaterialLaw<dim>& law, const Vector<dim>& low,
              const Vector<dim>& high, int cells, int points_per_cell)
      : soil(type, grid_cells), cell_size_(1.0 / grid_cells) {
    soil.bodies = {{"block", {"", 1, law}}};
    const auto count = Eigen::Matrix<int, dim, 1>::Constant(cells);
    lay_points<dim>({box_mesh<dim>(low, high, count, type), points_per_cell, Vector<dim>::Zero()},
                    1, {}, soil.points);
  }

  /// One step in which each node moves by H (x - centre); accepted.
  void move(const Matrix<dim>& H, const Vector<dim>& centre) {
    try_move(H, centre);
    grid_to_points(soil.nodes, motion_, soil.weights, 0, soil.points);
    accept();
  }

  /// The step of move() without accepting it: f_int only.
  void try_move(const Matrix<dim>& H, const Vector<dim>& centre) {
    soil.to_grid();
    motion_ = {};
    std::vector<double> du;
    for (std::int32_t i = 0; i < soil.nodes.size(); ++i) {
      motion_.du.push_back(H * (soil.node(i) - centre));
      du.insert(du.end(), motion_.du.back().data(), motion_.du.back().data() + dim);
    }
    motion_.v_new.assign(motion_.du.size(), Vector<dim>::Zero());
    motion_.a_new = motion_.v_new;
    mpm::InternalForces<dim> internal({soil.bodies, soil.points, soil.weights, soil.nodes, trial_},
                                      cell_size_, 0);
    mpm::RefusedPoint worst;
    require(internal.evaluate(du, nullptr, worst), "driven block: inadmissible move");
    internal.finish(du);
    f_int = internal.forces();
  }

 private:
  void accept() {
    for (std::int32_t e = 0; e < soil.points.size(); ++e) {
      const std::int32_t p = soil.weights.point[e];
      soil.points.history[p] = trial_.history[e];
      soil.points.tau[p] = trial_.tau[e];
      soil.points.energy[p] = trial_.energy[e];
      soil.points.J[p] *= trial_.J_ratio[e];
    }
  }

  double cell_size_;
  mpm::NodalMotion<dim> motion_;
  mpm::TrialPoints<dim> trial_;
};

}  // namespace gabion::test
