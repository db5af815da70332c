// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "common/mechanics/elements/cell_type.hpp"
#include "common/mechanics/tensor.hpp"
#include "common/settings/config_reader.hpp"
#include "common/settings/scene.hpp"

namespace gabion {

/// Facets by name, num_facets x num_nodes(facet_type(cell_type)) nodes.
using FacetGroups = std::map<std::string, std::vector<std::int32_t>>;

/// Facets of a group. @throws ConfigError naming the groups that exist; `where` says who asks.
const std::vector<std::int32_t>& find_facets(const FacetGroups& groups, const std::string& group,
                                             const std::string& where);
/// Nodes of a facet group, sorted, each once.
std::vector<std::int32_t> find_group_nodes(const FacetGroups& groups, const std::string& group,
                                           const std::string& where);

/// Numbers of cells, lines or nodes by name, ascending.
using NumberGroups = std::map<std::string, std::vector<std::int32_t>>;

/// An unstructured mesh of one cell type with named groups of facets and cells, and lines and, in
/// space, sheets between its nodes, such as ropes and membranes. It may consist of these alone.
template <int dim>
struct Mesh {
  CellType cell_type = dim == 2 ? CellType::tri3 : CellType::hex8;
  std::vector<Vector<dim>> nodes;   ///< [m]
  std::vector<std::int32_t> cells;  ///< num_cells x num_nodes(cell_type), positive volume
  /// Groups of facets on the boundary; each facet is ordered so that its normal points out of the
  /// cell it belongs to (2D: the cell lies to the left of the segment's direction, so the outward
  /// normal is the direction turned clockwise).
  FacetGroups facet_groups;
  NumberGroups cell_groups;
  std::vector<std::int32_t> lines;  ///< line cells (line2), num_lines x 2
  NumberGroups line_groups;
  std::vector<std::int32_t>
      sheets;  ///< surface cells, num_sheets x num_nodes(facet_type(cell_type))
  NumberGroups sheet_groups;
  NumberGroups node_groups;  ///< groups of points, in 3D also of curves: nodes of cells and lines
  std::string file;          ///< it was read from, as the scene names it; empty: made from numbers

  int nodes_per_cell() const { return num_nodes(cell_type); }
  std::int32_t num_cells() const {
    return static_cast<std::int32_t>(cells.size()) / nodes_per_cell();
  }
  std::int32_t num_lines() const { return static_cast<std::int32_t>(lines.size() / 2); }
  int nodes_per_sheet() const { return num_nodes(facet_type(cell_type)); }
  std::int32_t num_sheets() const {
    return static_cast<std::int32_t>(sheets.size()) / nodes_per_sheet();
  }
  /// Cells, then lines, then sheets.
  std::int32_t num_elements() const { return num_cells() + num_lines() + num_sheets(); }
  std::int32_t num_nodes_total() const { return static_cast<std::int32_t>(nodes.size()); }
  std::span<const std::int32_t> cell(std::int32_t c) const {
    return {cells.data() + static_cast<std::size_t>(c) * nodes_per_cell(),
            static_cast<std::size_t>(nodes_per_cell())};
  }
  std::span<const std::int32_t> line(std::int32_t l) const {
    return std::span(lines).subspan(static_cast<std::size_t>(l) * 2, 2);
  }
  std::span<const std::int32_t> sheet(std::int32_t s) const {
    const auto n = static_cast<std::size_t>(nodes_per_sheet());
    return std::span(sheets).subspan(static_cast<std::size_t>(s) * n, n);
  }
  /// Nodes of a cell or, behind the cells, of a line or, behind the lines, of a sheet.
  std::span<const std::int32_t> element(std::int32_t e) const {
    if (e < num_cells()) return cell(e);
    const std::int32_t behind_cells = e - num_cells();
    return behind_cells < num_lines() ? line(behind_cells) : sheet(behind_cells - num_lines());
  }

  const std::vector<std::int32_t>& facets(const std::string& group,
                                          const std::string& where) const {
    return find_facets(facet_groups, group, where);
  }
  /// Nodes of a group of facets or nodes, ascending.
  std::vector<std::int32_t> group_nodes(const std::string& group, const std::string& where) const;
};

/// Volume (2D: area) of a cell with these nodes [m^dim]; negative when their order is reversed
/// round.
template <int dim>
double cell_volume(CellType type, std::span<const Vector<dim>> nodes);
template <int dim>
double cell_volume(const Mesh<dim>& mesh, std::int32_t c);

/// Axis-aligned box of equal cells, told by numbers.
template <int dim>
struct BoxShape {
  Vector<dim> low, high;                 ///< opposite corners [m]
  Eigen::Matrix<int, dim, 1> num_cells;  ///< along each axis; rectangles or bricks
  CellType cell_type;
  bool alternate = false;  ///< see `box_mesh`
};

/// @throws ConfigError  type not of this dimension, high <= low, less than one cell, too many
template <int dim>
void check_box(const BoxShape<dim>& box);

/// Mesh of a box. Nodes and cells run along x first, then y, then z; the
/// triangles or tetrahedra of one rectangle or brick follow each other. Sides are the facet groups
/// left, right, bottom, top (3D also front, back: y is up in 2D, z is up in 3D; left/right = x,
/// front/back = y in 3D). tri3: each rectangle is cut along one diagonal, `alternate` flips it like
/// a chess board. tet4: six tetrahedra a brick; with `alternate` five, mirrored from brick to
/// brick. Quadratic cells: as the linear ones on their corners, see with_middle_nodes().
/// @throws ConfigError  as check_box()
template <int dim>
Mesh<dim> box_mesh(const Vector<dim>& low, const Vector<dim>& high,
                   const Eigen::Matrix<int, dim, 1>& num_cells, CellType cell_type,
                   bool alternate = false);

/// The mesh with cells of a quadratic type on the corners of its own; edges are straight, middle
/// nodes follow the others, cell by cell. @pre corner_type(type) is that of the cells
template <int dim>
Mesh<dim> with_middle_nodes(const Mesh<dim>& mesh, CellType type);

/// Orders of cells that a reader takes.
enum class CellOrders { linear, any };

/// Name of a side of a box: across an axis, at its low (0) or high (1) end.
const char* box_side_name(int dim, int axis, int end);

/// Groups of curves whose lines are cells, in space of surfaces, too, whose facets are; none: no
/// lines are wanted, groups of curves are facets in the plane and groups of nodes in space.
using LineGroupNames = std::optional<std::set<std::string>>;

/// Gmsh file, format 4.1, ASCII or binary. Physical groups of dimension dim-1 become facet groups,
/// of dimension dim cell groups, of lower dimension node groups. One cell type per mesh. Nodes that
/// no cell or line uses are dropped, cells of negative volume reordered, facets turned outward; a
/// facet between two cells stays as the file has it, and one of no cell of a group among the names
/// or between nodes of lines, such as the mesh of a net. A mesh of the plane must have one z for
/// all nodes. The map of a cell must be invertible at its corners, of a quadratic one at all of its
/// nodes.
/// @throws ConfigError  file and line or section, what was found; with lines: one without length,
///                      the same one twice, a group of curves on nodes of no cell that is not among
///                      the names
template <int dim>
Mesh<dim> read_gmsh(const std::string& path, const LineGroupNames& lines = std::nullopt,
                    CellOrders orders = CellOrders::linear);

/// Read {"file": "x.msh"} or {"box": {"low": [..], "high": [..], "cells": [..], "type": "quad4"}}.
template <int dim>
Mesh<dim> read_mesh(const Scene& scene, ConfigReader in, const LineGroupNames& lines = std::nullopt,
                    CellOrders orders = CellOrders::linear);
/// Like read_mesh(), but a box is not yet made into a mesh.
template <int dim>
std::variant<BoxShape<dim>, Mesh<dim>> read_box_or_mesh(const Scene& scene, ConfigReader in);
/// Like read_box_or_mesh(), but the file is not yet opened.
template <int dim>
std::variant<BoxShape<dim>, std::string> read_box_or_file(ConfigReader in,
                                                          CellOrders orders = CellOrders::linear);
/// Read what read_box_or_file() named. @param in  as there, for errors
template <int dim>
Mesh<dim> read_mesh_file(const Scene& scene, const ConfigReader& in, const std::string& file,
                         const LineGroupNames& lines = std::nullopt,
                         CellOrders orders = CellOrders::linear);
KeyTable mesh_keys();

/// Warn when the file of a mesh with one material has several groups of cells: they look like
/// several materials, and nothing tells them apart.
/// @param where  file and pointer of the mesh
template <int dim>
void warn_of_cell_groups(const Mesh<dim>& mesh, const std::string& where);

}  // namespace gabion
