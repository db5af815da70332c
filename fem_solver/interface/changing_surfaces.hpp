// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "common/run/facets.hpp"
#include "fem_solver/fem_config.hpp"
#include "fem_solver/interface/exposed_facets.hpp"
#include "fem_solver/interface/wet_surfaces.hpp"

namespace gabion::fem {

/// The interfaces with cells behind them that may leave (WetSurfaceSettings::behind): their facets
/// after each accepted step. A node whose cells are all gone flies on, but its vertex stays where
/// the node was then: no facet has it, and the coupling must not measure its steps by it.
template <int dim>
class ChangingSurfaces {
 public:
  /// Refers to the settings and the surfaces.
  /// @throws ConfigError  several ranks, quadratic cells; a facet of another interface on a cell
  ///                      that may leave
  ChangingSurfaces(const FemSettings<dim>& settings, const WetSurfaces<dim>& surfaces);

  /// Whether an interface may change.
  bool any() const { return !surfaces_.empty(); }
  /// Whether an interface has this cell behind it.
  bool has(std::int32_t cell) const { return !owner_.empty() && owner_[cell] >= 0; }
  /// Facets of these interfaces, by their vertices.
  const InterfaceFacets& facets() const { return facets_; }

  /// @param lost  share of its stress that each cell of the mesh lost, in the accepted state
  /// @param u     displacements then, num_nodes x dim [m]
  void accept(std::span<const double> lost, std::span<const double> u);
  /// Surfaces of a state that is loaded, from what visit_state has read of it.
  void load(std::span<const double> lost);
  /// Put the vertices that stay in their places.
  void hold(InterfaceValues& displacements) const;
  void visit_state(StateVisitor& visitor);

 private:
  struct Surface {
    std::string name;
    std::span<const std::int32_t> nodes;  // of its vertices, ascending
    ExposedFacets<dim> exposed;
  };
  void find_facets(std::span<const double> lost);
  std::vector<std::int64_t> loose_nodes(std::span<const double> lost) const;

  const FemSettings<dim>& settings_;
  std::vector<Surface> surfaces_;
  std::vector<std::int32_t> owner_;  // of each cell: the interface before it, -1: none
  std::int64_t num_gone_ = 0;        // cells
  InterfaceFacets facets_;
  std::vector<std::int64_t> loose_;  // nodes whose cells are all gone, ascending
  std::vector<double> places_;       // their displacements when the last one went [m]
};

}  // namespace gabion::fem
