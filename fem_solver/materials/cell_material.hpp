// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <variant>
#include <vector>

#include "common/mechanics/materials/material.hpp"
#include "fem_solver/materials/concrete.hpp"
#include "fem_solver/materials/failure.hpp"
#include "fem_solver/materials/rayleigh.hpp"
#include "fem_solver/materials/von_mises.hpp"

namespace gabion::fem {

/// Laws of cells: the elastic ones of common/mechanics, and those whose history lies on fixed axes.
template <int dim>
using CellLaw = std::variant<LinearElastic<dim>, NeoHookean<dim>, HenckyElastic<dim>, VonMises<dim>,
                             Concrete<dim>>;

/// A law that updates a history of its own.
template <class Law>
concept LawWithHistory = requires {
  Law::history_size;
};

/// Formulation by which a cell computes stresses from its nodes' displacements.
enum class Formulation {
  full,        ///< strain of the displacements, full integration
  enhanced,    ///< with enhanced assumed strains (quad4, hex8): bends, does not lock
  reduced,     ///< strain of the displacements, 2 points along each axis (quad8, hex20)
  solid_shell  ///< a plate or shell of one cell across (hex8), of any slenderness
};

/// Axis of a cell along which the thickness of a solid shell lies.
enum class Thickness {
  shortest,   ///< the shortest one
  numbering,  ///< from its first four nodes to the last four
  side        ///< between the facets of which one is in a group
};

/// Material of some cells.
template <int dim>
struct CellMaterial {
  std::string group;  ///< of its cells; empty: all cells
  std::string where;  ///< place of the group in the config, for errors
  std::string law_name;
  double density = 0;  ///< [kg/m^3], in the stress-free state
  CellLaw<dim> law;
  Formulation formulation = Formulation::full;
  Thickness thickness = Thickness::shortest;  ///< of solid shells
  std::string thickness_side;                 ///< group of facets, with Thickness::side
  std::string thickness_where;                ///< its place in the config, for errors
  RayleighFactors rayleigh;                   ///< K: elastic, before loading
  FailureLimits failure;
};

/// Number of values that the law remembers of a point.
template <int dim>
int history_size(const CellLaw<dim>& law) {
  return std::visit(
      []<class Law>(const Law&) {
        if constexpr (LawWithHistory<Law>) return Law::history_size;
        return 0;
      },
      law);
}

/// Keys of the material of all cells.
KeyTable cell_material_keys();
/// Keys of the material of a group of cells.
KeyTable group_material_keys();

/// Read what cell_material_keys() or, with a group, group_material_keys() list.
/// @throws ConfigError  a table of yield stresses that does not rise in strain, ...
template <int dim>
CellMaterial<dim> read_cell_material(ConfigReader in, bool of_group);

}  // namespace gabion::fem
