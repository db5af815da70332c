// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <optional>
#include <set>
#include <string>
#include <unordered_map>

#include "common/base/log.hpp"
#include "common/base/require.hpp"
#include "common/mechanics/elements/quadratic_cells.hpp"
#include "common/mechanics/elements/shape_functions.hpp"
#include "common/mechanics/mesh/boundary.hpp"
#include "common/mechanics/mesh/doubled_elements.hpp"
#include "common/mechanics/mesh/gmsh_file.hpp"
#include "common/mechanics/mesh/gmsh_lines.hpp"
#include "common/mechanics/mesh/mesh.hpp"
#include "common/mechanics/mesh/surface_mesh.hpp"

namespace gabion {

namespace {

/// What the caller wants of a file.
struct MeshWish {
  const LineGroupNames& lines;
  CellOrders orders = CellOrders::linear;
  /// Facet groups whose facets have to be those of cells; null: all.
  const std::vector<std::string>* facets = nullptr;
};

CellType cell_type_of(int gmsh_type) {
  return cell_type_of_gmsh(gmsh_type).value_or(CellType::point1);
}

/// A type of cells in space with facets of this type.
CellType type_with_facets(CellType facet) {
  for (const CellType type : {CellType::tet4, CellType::tet10, CellType::hex20, CellType::hex27}) {
    if (facet_type(type) == facet) return type;
  }
  return CellType::hex8;
}

/// A type of cells whose facets are those of the file; for meshes of lines and sheets alone.
template <int dim>
CellType type_of_facets(const GmshFile& file, const std::string& path) {
  std::optional<CellType> result;
  for (const auto& block : file.element_blocks) {
    const CellType facet = cell_type_of(block.type);
    if (dim == 2 || dimension(facet) != dim - 1) continue;
    const CellType type = type_with_facets(facet);
    require<ConfigError>(!result || *result == type,
                         "{}: section $Elements: found facets of types {} and {} in a mesh without "
                         "solid cells, allowed: one type a mesh",
                         path, name(facet_type(result.value_or(type))), name(facet));
    result = type;
  }
  return result.value_or(dim == 2 ? CellType::quad4 : CellType::hex8);
}

/// What to say of the groups of a file without cells: a misspelt group of lines leaves it so.
std::string names_of_groups(const GmshFile& file) {
  std::set<std::string> names;
  for (const auto& block : file.element_blocks) {
    for (const std::string& name : group_names(file, block)) names.insert(name);
  }
  if (names.empty()) return "";
  return fmt::format("; its groups: {}", fmt::join(names, ", "));
}

/// The one type of the cells of dimension `dim`.
template <int dim>
CellType find_cell_type(const GmshFile& file, const std::string& path, bool has_others,
                        CellOrders orders) {
  std::optional<CellType> result;
  int highest = -1;
  for (const auto& block : file.element_blocks) {
    if (block.nodes.empty()) continue;
    const CellType type = cell_type_of(block.type);
    highest = std::max(highest, dimension(type));
    if (dimension(type) != dim) continue;
    require<ConfigError>(!result || *result == type,
                         "{}: section $Elements: found cells of types {} and {}, "
                         "allowed: one type a mesh",
                         path, name(result.value_or(type)), name(type));
    require<ConfigError>(orders == CellOrders::any || !is_quadratic(type),
                         "{}: section $Elements: found cells of type {}, which are of order 2, "
                         "allowed: {}, of order 1, here",
                         path, name(type), dim == 2 ? "tri3, quad4" : "tet4, hex8");
    result = type;
  }
  require<ConfigError>(highest <= dim,
                       "{}: section $Elements: found elements of dimension {}, "
                       "allowed: a mesh of dimension {}",
                       path, highest, dim);
  if (!result && has_others) return type_of_facets<dim>(file, path);
  require<ConfigError>(result.has_value(),
                       "{}: section $Elements: found no cells of dimension {} (the "
                       "highest dimension is {}{}); a Gmsh file holds only elements of "
                       "physical groups once there is one",
                       path, dim, highest, names_of_groups(file));
  return *result;
}

/// Maps node tags of the file to positions in its list of nodes.
std::unordered_map<std::uint64_t, std::size_t> index_nodes(const GmshFile& file,
                                                           const std::string& path) {
  std::unordered_map<std::uint64_t, std::size_t> index;
  index.reserve(file.node_tags.size());
  for (std::size_t i = 0; i < file.node_tags.size(); ++i) {
    require<ConfigError>(index.emplace(file.node_tags[i], i).second,
                         "{}: section $Nodes: found node {} twice", path, file.node_tags[i]);
  }
  return index;
}

/// Collects nodes in the order of the file, those of cells and lines only.
template <int dim>
class MeshBuilder {
 public:
  MeshBuilder(const GmshFile& file, const std::string& path, const MeshWish& wish)
      : file_(file),
        path_(path),
        lines_(wish.lines),
        wanted_facets_(wish.facets),
        position_of_tag_(index_nodes(file, path)),
        origin_{.file = file, .path = path, .cells = {}, .facets = {}} {
    const bool has_others = std::ranges::any_of(file.element_blocks, [this](const auto& block) {
      return !line_groups_of(block).empty() || !sheet_groups_of(block).empty();
    });
    mesh_.cell_type = find_cell_type<dim>(file, path, has_others, wish.orders);
  }

  Mesh<dim> build() {
    number_nodes();
    for (const auto& block : file_.element_blocks) {
      if (dimension(cell_type_of(block.type)) == dim) add_cells(block);
    }
    for (std::int32_t c = 0; c < mesh_.num_cells(); ++c) orient_cell(c);
    settle_doubled_cells(origin_, mesh_);
    const FacetOwners owners(mesh_);
    refuse_cells_on_one_side(origin_, owners, mesh_);
    GmshLines<dim> lines(origin_, mesh_);
    for (const auto& block : file_.element_blocks) {
      const auto groups = line_groups_of(block);
      if (!groups.empty()) {
        require<ConfigError>(cell_type_of(block.type) == CellType::line2,
                             "{}: section $Elements: found the group of lines \"{}\" with lines of "
                             "{} nodes, allowed: 2 (order 1)",
                             path_, groups[0], gmsh_num_nodes(block.type));
        lines.add(block, groups, numbers_of(block));
      }
      if (block.dimension < dim - 1) add_node_groups(block);
    }
    on_line_.assign(mesh_.nodes.size(), 0);
    for (const std::int32_t i : mesh_.lines) on_line_[i] = 1;
    for (const auto& block : file_.element_blocks) {
      if (dimension(cell_type_of(block.type)) == dim - 1) add_facets(block, owners);
    }
    settle_doubled_facets(origin_, mesh_);
    warn_of_empty_groups();
    return std::move(mesh_);
  }

 private:
  std::size_t position(std::uint64_t tag) const {
    const auto found = position_of_tag_.find(tag);
    require<ConfigError>(found != position_of_tag_.end(),
                         "{}: section $Elements: found node {}, which $Nodes does not "
                         "have",
                         path_, tag);
    return found->second;
  }

  /// Names of the groups of a block whose lines are cells.
  std::vector<std::string> line_groups_of(const GmshFile::ElementBlock& block) const {
    return block.dimension == 1 ? wanted_groups_of(block) : std::vector<std::string>();
  }
  /// Names of the groups of a block whose facets are cells.
  std::vector<std::string> sheet_groups_of(const GmshFile::ElementBlock& block) const {
    return dim == 3 && block.dimension == 2 ? wanted_groups_of(block) : std::vector<std::string>();
  }
  std::vector<std::string> wanted_groups_of(const GmshFile::ElementBlock& block) const {
    if (!lines_ || block.tags.empty()) return {};
    auto groups = group_names(file_, block);
    std::erase_if(groups, [this](const auto& group) { return !lines_->contains(group); });
    return groups;
  }

  /// Nodes of a block's elements in the mesh; -1: not one of it.
  std::vector<std::int32_t> numbers_of(const GmshFile::ElementBlock& block) const {
    std::vector<std::int32_t> numbers;
    for (std::uint64_t tag : block.nodes) numbers.push_back(number_[position(tag)]);
    return numbers;
  }

  void add_node_groups(const GmshFile::ElementBlock& block) {
    auto nodes = numbers_of(block);
    std::erase(nodes, -1);
    const auto groups = group_names(file_, block);
    if (groups.empty() || block.tags.empty()) return;
    require<ConfigError>(!lines_ || block.dimension != 1 || !nodes.empty(),
                         "{}: section $Elements: found the group of lines \"{}\" with nodes of no "
                         "cell, allowed: a material of the lines (\"law\" \"truss\", \"cable\" or "
                         "\"brake\"), or no such group",
                         path_, groups[0]);
    for (const auto& group : groups) {
      if (nodes.empty()) continue;
      auto& all = mesh_.node_groups[group];
      all.insert(all.end(), nodes.begin(), nodes.end());
      std::ranges::sort(all);
      all.erase(std::unique(all.begin(), all.end()), all.end());
    }
  }

  void number_nodes() {
    number_.assign(file_.node_tags.size(), -1);
    for (const auto& block : file_.element_blocks) {
      if (dimension(cell_type_of(block.type)) != dim && line_groups_of(block).empty() &&
          sheet_groups_of(block).empty()) {
        continue;
      }
      for (std::uint64_t tag : block.nodes) number_[position(tag)] = 0;
    }
    std::array<double, 3> low, high;
    low.fill(INFINITY);
    high.fill(-INFINITY);
    for (std::size_t i = 0; i < number_.size(); ++i) {
      if (number_[i] < 0) continue;
      number_[i] = mesh_.num_nodes_total();
      mesh_.nodes.push_back(Vector<dim>(file_.node_positions[i].data()));
      for (int k = 0; k < 3; ++k) {
        low[k] = std::min(low[k], file_.node_positions[i][k]);
        high[k] = std::max(high[k], file_.node_positions[i][k]);
      }
    }
    const double extent = std::max(high[0] - low[0], high[1] - low[1]);
    require<ConfigError>(dim == 3 || high[2] - low[2] <= 1e-10 * extent,
                         "{}: section $Nodes: found z from {} to {}, allowed: one z "
                         "for all nodes of a mesh of dimension 2",
                         path_, low[2], high[2]);
  }

  void add_cells(const GmshFile::ElementBlock& block) {
    const std::int32_t first = mesh_.num_cells();
    for (std::uint64_t tag : block.nodes) mesh_.cells.push_back(number_[position(tag)]);
    for (std::uint64_t tag : block.tags) origin_.cells.push_back({&block, tag});
    for (const auto& group : group_names(file_, block)) {
      auto& cells = mesh_.cell_groups[group];
      for (std::int32_t c = first; c < mesh_.num_cells(); ++c) cells.push_back(c);
    }
  }

  /// Make the volume positive; refuse a cell whose map is not invertible at each node.
  void orient_cell(std::int32_t c) {
    const int n = mesh_.nodes_per_cell();
    std::int32_t* cell = &mesh_.cells[static_cast<std::size_t>(c) * n];
    if (cell_volume(mesh_, c) < 0) {
      mirror_cell(mesh_.cell_type, {cell, static_cast<std::size_t>(n)});
    }
    Vector<dim> low = mesh_.nodes[cell[0]], high = low;
    for (int a = 1; a < n; ++a) {
      low = low.cwiseMin(mesh_.nodes[cell[a]]);
      high = high.cwiseMax(mesh_.nodes[cell[a]]);
    }
    if (smallest_determinant(c) > 1e-12 * std::pow((high - low).maxCoeff(), dim)) return;
    throw ConfigError(fmt::format(
        "{}: section $Elements: found a degenerate, folded or non-convex {} near ({}), element {}, "
        "allowed: cells of positive Jacobian",
        path_, name(mesh_.cell_type), fmt::join(low, ", "), origin_.cells[c].tag));
  }

  /// Smallest Jacobian determinant of the map of a cell, at its nodes.
  double smallest_determinant(std::int32_t c) const {
    const auto cell = mesh_.cell(c);
    const bool affine = is_simplex(mesh_.cell_type) && !is_quadratic(mesh_.cell_type);
    double smallest = INFINITY;
    AnyShapeValues<dim> shape;
    for (std::size_t node = 0; node < (affine ? 1 : cell.size()); ++node) {
      const Vector<dim> xi = node_place<dim>(mesh_.cell_type, static_cast<int>(node));
      shape_functions<dim>(mesh_.cell_type, xi, shape);
      Matrix<dim> jacobian = Matrix<dim>::Zero();
      for (std::size_t a = 0; a < cell.size(); ++a) {
        jacobian += mesh_.nodes[cell[a]] * shape.dN[a].transpose();
      }
      smallest = std::min(smallest, jacobian.determinant());
    }
    return smallest;
  }

  /// Whether facets of these groups may belong to no cell, such as ropes of the plane beside them.
  bool may_be_loose(const std::vector<std::string>& groups) const {
    return wanted_facets_ && std::ranges::none_of(groups, [this](const auto& group) {
             return std::ranges::find(*wanted_facets_, group) != wanted_facets_->end();
           });
  }

  void add_facets(const GmshFile::ElementBlock& block, const FacetOwners& owners) {
    const auto groups = group_names(file_, block);
    const CellType type = facet_type(mesh_.cell_type);
    const std::size_t n = gmsh_num_nodes(block.type);
    if (groups.empty() || block.tags.empty()) return;
    const bool loose = may_be_loose(groups), sheets = !sheet_groups_of(block).empty();
    require<ConfigError>(!sheets || cell_type_of(block.type) == type,
                         "{}: section $Elements: found facets of type {} in group \"{}\", allowed: "
                         "{}, the facets of cells of type {}",
                         path_, name(cell_type_of(block.type)), groups[0], name(type),
                         name(mesh_.cell_type));
    std::vector<std::int32_t> facets;
    std::vector<FileElement> origins;
    for (std::size_t first = 0; first < block.nodes.size(); first += n) {
      std::array<std::int32_t, max_facet_nodes> facet;
      for (std::size_t a = 0; a < n; ++a) facet[a] = number_[position(block.nodes[first + a])];
      const auto found = owners.find({facet.data(), n});
      if (found.empty() && loose) continue;
      const bool between_lines = mesh_.num_lines() > 0 && cell_type_of(block.type) == type &&
                                 std::all_of(facet.begin(), facet.begin() + n, [&](std::int32_t i) {
                                   return i >= 0 && on_line_[i] != 0;
                                 });
      require<ConfigError>(
          !found.empty() || between_lines || sheets,
          "{}: section $Elements: found a facet of group \"{}\" "
          "(nodes {}) that belongs to no cell",
          path_, groups[0],
          fmt::join(block.nodes.begin() + first, block.nodes.begin() + first + n, ", "));
      if (found.size() == 1) facet = cell_facet(mesh_, found[0].cell, found[0].facet);
      facets.insert(facets.end(), facet.begin(), facet.begin() + n);
      origins.push_back({&block, block.tags[first / n]});
    }
    if (facets.empty()) return;
    for (const auto& group : groups) {
      auto& all = mesh_.facet_groups[group];
      all.insert(all.end(), facets.begin(), facets.end());
      auto& all_origins = origin_.facets[group];
      all_origins.insert(all_origins.end(), origins.begin(), origins.end());
    }
  }

  /// Warn of names that have no facet or cell.
  void warn_of_empty_groups() const {
    for (const auto& [key, name] : file_.physical_names) {
      const bool is_facets = key.first == dim - 1;
      if (!is_facets && key.first != dim) continue;
      if (is_facets && may_be_loose({name})) continue;
      if (is_facets ? mesh_.facet_groups.contains(name) : mesh_.cell_groups.contains(name))
        continue;
      log::warn("{}: section $PhysicalNames: found the name \"{}\" of a group of {} that has none",
                path_, name, is_facets ? "facets" : "cells");
    }
  }

  const GmshFile& file_;
  const std::string& path_;
  const LineGroupNames& lines_;
  const std::vector<std::string>* wanted_facets_;
  std::unordered_map<std::uint64_t, std::size_t> position_of_tag_;
  MeshOrigin origin_;
  std::vector<std::int32_t> number_;  // by position in the file; -1: no cell uses it
  std::vector<char> on_line_;         // by node
  Mesh<dim> mesh_;
};

}  // namespace

template <int dim>
Mesh<dim> read_gmsh(const std::string& path, const LineGroupNames& lines, CellOrders orders) {
  const GmshFile file = read_gmsh_file(path);
  return MeshBuilder<dim>(file, path, {.lines = lines, .orders = orders}).build();
}

template <int dim>
Mesh<dim> read_gmsh_surface(const std::string& path, const std::vector<std::string>& groups) {
  const GmshFile file = read_gmsh_file(path);
  const LineGroupNames no_lines;
  return MeshBuilder<dim>(file, path, {.lines = no_lines, .facets = &groups}).build();
}

template Mesh<2> read_gmsh(const std::string&, const LineGroupNames&, CellOrders);
template Mesh<3> read_gmsh(const std::string&, const LineGroupNames&, CellOrders);
template Mesh<2> read_gmsh_surface(const std::string&, const std::vector<std::string>&);
template Mesh<3> read_gmsh_surface(const std::string&, const std::vector<std::string>&);

}  // namespace gabion
