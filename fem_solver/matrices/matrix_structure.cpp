// SPDX-License-Identifier: BSD-3-Clause
#include "fem_solver/matrices/matrix_structure.hpp"

#include <fmt/format.h>

#include <limits>
#include <map>
#include <set>
#include <utility>

#include "common/base/log.hpp"
#include "common/base/require.hpp"
#include "common/mechanics/mesh/seen_facets.hpp"
#include "fem_solver/matrices/matrix_files.hpp"
#include "fem_solver/matrices/number_lines.hpp"

namespace gabion::fem {

namespace {

constexpr std::int64_t largest_number = std::numeric_limits<std::int32_t>::max();
using Held = std::set<std::pair<std::int64_t, int>>;
using NodeOf = std::map<std::int64_t, std::int32_t>;

/// Matrices as the files have them, over all their rows.
struct Rows {
  LinearModel model;
  Eigen::VectorXd load;
  std::string unknowns_path;
};

void require_size(std::int64_t size, const std::string& path, const Rows& rows) {
  require<ConfigError>(size == std::ssize(rows.model.unknowns),
                       "{}: found {} rows, allowed: {}, the unknowns of {}", path, size,
                       rows.model.unknowns.size(), rows.unknowns_path);
}

SparseMatrix read_of_size(const std::string& path, const Rows& rows) {
  SparseMatrix A = read_symmetric_matrix(path);
  require_size(A.rows(), path, rows);
  return A;
}

template <int dim>
Rows read_rows(const Scene& scene, const MatrixSettings<dim>& s) {
  const MatrixFiles& files = s.files;
  Rows rows;
  LinearModel& model = rows.model;
  rows.unknowns_path = scene.path(files.unknowns);
  model.unknowns = read_unknowns(rows.unknowns_path);
  model.K = read_of_size(scene.path(files.stiffness), rows);
  if (!files.mass.empty()) model.M = read_of_size(scene.path(files.mass), rows);
  if (!files.damping.empty()) model.C = read_of_size(scene.path(files.damping), rows);
  if (s.rayleigh.mass > 0 || s.rayleigh.stiffness > 0) {
    model.C = s.rayleigh.mass * model.M + s.rayleigh.stiffness * model.K;
  }
  rows.load = Eigen::VectorXd::Zero(model.size());
  if (!files.load.empty()) {
    rows.load = read_vector(scene.path(files.load));
    require_size(rows.load.size(), scene.path(files.load), rows);
  }
  return rows;
}

/// @throws ConfigError  a node that has neither an unknown nor coordinates
Held read_held_of(const std::string& path, const Rows& rows, const NodeOf& node_of) {
  std::set<std::int64_t> nodes;
  for (const Unknown& unknown : rows.model.unknowns) nodes.insert(unknown.node);
  Held held;
  for (const Unknown& unknown : read_held(path)) {
    require<ConfigError>(nodes.contains(unknown.node) || node_of.contains(unknown.node),
                         "{}: found node {}, allowed: nodes with coordinates or unknowns", path,
                         unknown.node);
    held.emplace(unknown.node, unknown.direction);
  }
  return held;
}

/// Unknowns that stay, ascending.
std::vector<int> free_rows(const Rows& rows, const Held& held) {
  std::vector<int> result;
  for (std::size_t i = 0; i < rows.model.unknowns.size(); ++i) {
    const Unknown& unknown = rows.model.unknowns[i];
    if (!held.contains({unknown.node, unknown.direction})) result.push_back(static_cast<int>(i));
  }
  require<ConfigError>(!result.empty(), "{}: found no free unknown, allowed: at least one",
                       rows.unknowns_path);
  return result;
}

template <int dim>
NodeOf read_nodes(const std::string& path, MatrixStructure<dim>& structure) {
  NumberLines lines(path);
  NodeOf node_of;
  const char* meaning = dim == 2 ? "node, x, y" : "node, x, y, z";
  for (auto row = lines.next(dim + 1, meaning); !row.empty(); row = lines.next(dim + 1, meaning)) {
    const auto number = lines.whole(row[0], 1, largest_number, "node");
    const auto node = static_cast<std::int32_t>(node_of.size());
    if (!node_of.emplace(number, node).second) {
      lines.fail(fmt::format("found node {} a second time, allowed: once", number));
    }
    structure.node_numbers.push_back(number);
    structure.mesh.nodes.push_back(Eigen::Map<const Vector<dim>>(row.data() + 1));
  }
  require<ConfigError>(!node_of.empty(), "{}: found no node, allowed: at least one", path);
  return node_of;
}

/// Rows of nodes as their places in the mesh.
struct NodeRows {
  std::size_t width = 0;
  std::vector<std::int32_t> nodes;
};

NodeRows read_node_rows(const std::string& path, const NodeOf& node_of,
                        const std::vector<std::size_t>& widths) {
  NumberLines lines(path);
  NodeRows rows;
  for (auto row = lines.next(); !row.empty(); row = lines.next()) {
    if (rows.width == 0) rows.width = row.size();
    const bool good = row.size() == rows.width &&
                      std::find(widths.begin(), widths.end(), rows.width) != widths.end();
    if (!good) {
      lines.fail(fmt::format("found {} nodes, allowed: {}, equal in all rows", row.size(),
                             fmt::join(widths, " or ")));
    }
    for (const double value : row) {
      const auto found = node_of.find(lines.whole(value, 1, largest_number, "node"));
      if (found == node_of.end()) {
        lines.fail(fmt::format("found node {}, allowed: nodes with coordinates", value));
      }
      rows.nodes.push_back(found->second);
    }
  }
  require<ConfigError>(rows.width > 0, "{}: found no row, allowed: at least one", path);
  return rows;
}

std::vector<CellType> cell_types(int dim) {
  if (dim == 2) {
    return {CellType::tri3, CellType::quad4, CellType::tri6, CellType::quad8, CellType::quad9};
  }
  return {CellType::tet4, CellType::hex8, CellType::tet10, CellType::hex20, CellType::hex27};
}

CellType cell_of(int dim, std::size_t width) {
  const auto types = cell_types(dim);
  return *std::ranges::find(types, static_cast<int>(width), num_nodes);
}

/// A cell whose facets have so many nodes.
CellType cell_with_facets(int dim, std::size_t width) {
  if (dim == 2) return width == 2 ? CellType::quad4 : CellType::quad8;
  const auto types = cell_types(dim);
  return *std::ranges::find(types, static_cast<int>(width),
                            [](CellType type) { return num_nodes(facet_type(type)); });
}

/// @throws ConfigError  a facet that is there already
template <int dim>
void require_new_facets(const Mesh<dim>& mesh, const NodeRows& facets, const std::string& where,
                        SeenFacets<dim>& seen) {
  for (std::size_t f = 0; f < facets.nodes.size(); f += facets.width) {
    require<ConfigError>(
        seen.add(mesh.nodes, std::span(facets.nodes).subspan(f, facets.width)),
        "{}: found facet {} a second time, allowed: each facet in one interface and once", where,
        f / facets.width + 1);
  }
}

template <int dim>
void read_mesh_files(const Scene& scene, const MatrixSettings<dim>& s, const NodeOf& node_of,
                     Mesh<dim>& mesh) {
  const bool has_cells = !s.files.cells.empty();
  if (has_cells) {
    const std::vector<std::size_t> widths = dim == 2 ? std::vector<std::size_t>{3, 4, 6, 8, 9}
                                                     : std::vector<std::size_t>{4, 8, 10, 20, 27};
    NodeRows cells = read_node_rows(scene.path(s.files.cells), node_of, widths);
    mesh.cell_type = cell_of(dim, cells.width);
    mesh.cells = std::move(cells.nodes);
  }
  const std::vector<std::size_t> widths =
      dim == 2 ? std::vector<std::size_t>{2, 3} : std::vector<std::size_t>{3, 4, 6, 8, 9};
  SeenFacets<dim> seen;
  for (const auto& interface : s.interfaces) {
    const std::string& file = interface.groups.front();
    NodeRows facets = read_node_rows(scene.path(file), node_of, widths);
    if (!has_cells && mesh.facet_groups.empty()) {
      mesh.cell_type = cell_with_facets(dim, facets.width);
    }
    const int expected = num_nodes(facet_type(mesh.cell_type));
    require<ConfigError>(static_cast<int>(facets.width) == expected,
                         "{}: found facets of {} nodes, allowed: {} as of the other surfaces and "
                         "cells",
                         interface.where, facets.width, expected);
    require_new_facets(mesh, facets, interface.where, seen);
    mesh.facet_groups[file] = std::move(facets.nodes);
  }
}

/// @throws ConfigError  a component that is neither an unknown nor held: it would depend on others
template <int dim>
void connect_unknowns(const MatrixSettings<dim>& s, const NodeOf& node_of, const Held& held,
                      MatrixStructure<dim>& structure) {
  structure.unknown_of.assign(structure.mesh.nodes.size() * dim, -1);
  const auto& unknowns = structure.model.unknowns;
  for (std::size_t i = 0; i < unknowns.size(); ++i) {
    const auto found = node_of.find(unknowns[i].node);
    if (found == node_of.end() || unknowns[i].direction > dim) continue;
    structure
        .unknown_of[static_cast<std::size_t>(found->second) * dim + unknowns[i].direction - 1] =
        static_cast<std::int32_t>(i);
  }
  for (std::size_t dof = 0; dof < structure.unknown_of.size(); ++dof) {
    const Unknown component = {structure.node_numbers[dof / dim], static_cast<int>(dof % dim) + 1};
    require<ConfigError>(
        structure.unknown_of[dof] >= 0 || held.contains({component.node, component.direction}),
        "{}: {} has coordinates in {}, and no row in {}; allowed: with a row, or listed in "
        "\"held\"",
        s.where, name(component), s.files.nodes, s.files.unknowns);
  }
}

/// Refuse a surface of which nothing can move: its node numbers are probably those of something
/// else.
template <int dim>
void require_free_surfaces(const MatrixSettings<dim>& s, const MatrixStructure<dim>& structure) {
  for (const auto& interface : s.interfaces) {
    const auto nodes = structure.mesh.group_nodes(interface.groups.front(), interface.where);
    std::size_t moving = 0;
    for (const auto node : nodes) {
      for (int c = 0; c < dim; ++c) {
        moving += structure.unknown_of[static_cast<std::size_t>(node) * dim + c] >= 0;
      }
    }
    require<ConfigError>(moving > 0,
                         "{}: found no node that has an unknown among {}, allowed: at least one",
                         interface.where, nodes.size());
    log::info("interface \"{}\": {} of {} components of its displacement are free", interface.name,
              moving, nodes.size() * dim);
  }
}

}  // namespace

template <int dim>
MatrixStructure<dim> read_matrix_structure(const Scene& scene,
                                           const MatrixSettings<dim>& settings) {
  const Rows rows = read_rows(scene, settings);
  MatrixStructure<dim> structure;
  const NodeOf node_of = read_nodes(scene.path(settings.files.nodes), structure);
  Held held;
  if (!settings.files.held.empty()) {
    held = read_held_of(scene.path(settings.files.held), rows, node_of);
  }
  const std::vector<int> kept = free_rows(rows, held);
  structure.model = part_of(rows.model, kept);
  structure.load = rows.load(kept);
  read_mesh_files(scene, settings, node_of, structure.mesh);
  connect_unknowns(settings, node_of, held, structure);
  require_free_surfaces(settings, structure);
  return structure;
}

template MatrixStructure<2> read_matrix_structure<2>(const Scene&, const MatrixSettings<2>&);
template MatrixStructure<3> read_matrix_structure<3>(const Scene&, const MatrixSettings<3>&);

}  // namespace gabion::fem
