// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "fem_solver/fem_config.hpp"
#include "fem_solver/step/structure_state.hpp"
#include "fem_solver/stress/cell_integrals.hpp"

namespace gabion::fem {

/// Force and moment that the part of a structure in front of a plane exerts on the part behind it:
/// sums of the nodal forces of the cells and lines behind, at the nodes that both parts have. They
/// balance loads, reactions, inertia and damping of the part behind to rounding. A cell or line is
/// behind when its centre is, before loading: the cut follows cell sides.
template <int dim>
class SectionForces {
 public:
  /// Refers to the mesh and ranks of the settings.
  /// @param cells  of the same settings
  /// @throws ConfigError  a plane that leaves no common node of two parts
  /// @note Collective.
  SectionForces(const FemSettings<dim>& settings, const SectionSettings<dim>& section,
                const CellIntegrals<dim>& cells);

  /// Columns of probes.csv: NAME.N along the normal [N], tension positive; NAME.V_x, ... the rest
  /// of the force; NAME.M_z, in space NAME.M_x, ... moment [N m], all on fixed axes, about the
  /// point moved by the mean displacement of the nodes of the cut.
  std::vector<std::string> names() const;
  /// @note Collective.
  std::vector<double> values(const StructureState& state, const CellIntegrals<dim>& cells) const;

 private:
  /// Some cells or lines of a block.
  template <class Block>
  struct Part {
    Block block;
    std::size_t of_block;             // number of the block whose they are
    std::vector<std::size_t> places;  // among the cells of that block
  };
  void find_parts(const FemSettings<dim>& settings, const CellIntegrals<dim>& cells);
  void find_membrane_parts(const FemSettings<dim>& settings, const CellIntegrals<dim>& cells);
  void count_links(const CellIntegrals<dim>& cells, std::vector<double>& sides);
  bool is_behind(std::span<const std::int32_t> nodes) const;
  bool is_cut(const FemSettings<dim>& settings, std::int32_t element) const;
  std::vector<double> forces_behind(const StructureState& state,
                                    const CellIntegrals<dim>& cells) const;

  const Mesh<dim>& mesh_;
  const MeshRanks& ranks_;
  SectionSettings<dim> section_;
  BeamNodes beam_nodes_;   // of the settings
  std::vector<char> cut_;  // by node: parts on both sides have it
  double num_cut_ = 0;     // nodes of all ranks
  std::vector<Part<CellBlock<dim>>> cell_parts_;
  std::vector<Part<LineBlock<dim>>> line_parts_;
  std::vector<MembraneBlock> membrane_parts_;
  RigidLinks<dim> links_;           // that are behind
  std::vector<std::size_t> whose_;  // number of each among all links
};

}  // namespace gabion::fem
