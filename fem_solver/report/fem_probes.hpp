// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "fem_solver/fem_config.hpp"
#include "fem_solver/step/equilibrium.hpp"
#include "fem_solver/step/structure_state.hpp"

namespace gabion::fem {

/// Columns of a structure in probes.csv: displacements of points, then kinetic_energy,
/// elastic_energy, external_work [J], momentum_<c> [kg m/s], then reaction_<group>_<c> [N] of the
/// supports that ask for it (force of the support on the structure), and moment_<group>_<c> [N m];
/// where cells may yield, plastic_work [J] and the largest plastic strain of a point, of all cells
/// and of each group; of each group of lines the largest and the least force, axial_max_<group> and
/// axial_min_<group> [N], of beams the largest shear_max_<group> [N], bending_max_<group> at their
/// ends and torsion_max_<group> [N m], and the largest run of brakes, brake_run_<group> [m];
/// brake_work [J]; stress_max_<group> and stress_min_<group> [Pa] of bars; damping_work [J] where
/// there is damping; damage_work [J] and the widest crack of all cells and of each group [m] where
/// cells may crack; failed_cells, cells and lines that failed, and failed_energy [J], the elastic
/// energy that they had, where some may fail. In the step in which a line begins to fail its forces
/// are those that broke it.
template <int dim>
class FemProbes {
 public:
  /// Refers to the settings.
  /// @throws ConfigError  a probe point outside the mesh
  /// @note Collective.
  explicit FemProbes(const FemSettings<dim>& settings);

  const std::vector<std::string>& names() const { return names_; }
  /// @note Collective.
  std::vector<double> values(const StructureState& state,
                             const Equilibrium<dim>& equilibrium) const;

 private:
  struct Point {
    std::vector<std::int32_t> nodes;  // of this rank; one rank has those of a point
    std::vector<double> weights;      // shape functions at the point
  };
  struct Reaction {
    std::vector<std::int32_t> nodes;      // that this rank owns
    std::vector<std::int32_t> rotations;  // of those of beams
    bool force = false, moment = false;
    Vector<dim> centre = Vector<dim>::Zero();  // of the facets before loading
  };
  void add_reaction(const FemSettings<dim>& settings, const SupportSettings& support);
  void add_values(const Reaction& reaction, const StructureState& state,
                  std::vector<double>& values) const;
  void add_plastic(const StructureState& state, const CellIntegrals<dim>& cells,
                   std::vector<double>& values) const;
  void add_damage(const StructureState& state, const CellIntegrals<dim>& cells,
                  std::vector<double>& values) const;
  void add_lines(const StructureState& state, const CellIntegrals<dim>& cells,
                 std::vector<double>& values) const;
  static Point locate(const FemSettings<dim>& settings, const ProbeSettings<dim>& probe);

  const MeshRanks& ranks_;
  const Mesh<dim>& mesh_;
  const FemSettings<dim>& settings_;
  std::vector<std::string> names_;
  std::vector<Point> points_;
  std::vector<Reaction> reactions_;
  void name_yielding(const FemSettings<dim>& settings);
  bool yields_ = false;
  bool brakes_ = false;  // there are some
};

}  // namespace gabion::fem
