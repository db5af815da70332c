// SPDX-License-Identifier: BSD-3-Clause
#include "common/mechanics/mesh/mesh.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <utility>

#include "common/base/error.hpp"
#include "common/base/log.hpp"
#include "common/mechanics/elements/shape_functions.hpp"
#include "common/mechanics/mesh/surface_mesh.hpp"

namespace gabion {

const std::vector<std::int32_t>& find_facets(const FacetGroups& groups, const std::string& group,
                                             const std::string& where) {
  const auto found = groups.find(group);
  if (found != groups.end()) return found->second;
  std::vector<std::string> names;
  for (const auto& [known, facets] : groups) names.push_back(known);
  throw ConfigError(
      fmt::format("{}: found facet group \"{}\", the mesh has: {}", where, group,
                  names.empty() ? "none" : fmt::format("{}", fmt::join(names, ", "))));
}

std::vector<std::int32_t> find_group_nodes(const FacetGroups& groups, const std::string& group,
                                           const std::string& where) {
  std::vector<std::int32_t> result = find_facets(groups, group, where);
  std::sort(result.begin(), result.end());
  result.erase(std::unique(result.begin(), result.end()), result.end());
  return result;
}

template <int dim>
std::vector<std::int32_t> Mesh<dim>::group_nodes(const std::string& group,
                                                 const std::string& where) const {
  if (facet_groups.contains(group)) return find_group_nodes(facet_groups, group, where);
  FacetGroups known = node_groups;  // groups of one node each "facet"
  known.insert(facet_groups.begin(), facet_groups.end());
  return find_group_nodes(known, group, where);
}

namespace {

/// Degree of det(dx/dxi): constant in tri3 and tet4, 1 (quad4) or 2 (hex8) in each coordinate;
/// of quadratic cells 2 (tri6), 3 (tet10), and in each coordinate 3 (quads) or 5 (hexahedra).
int determinant_degree(CellType type) {
  const int dim = dimension(type);
  if (is_simplex(type)) return is_quadratic(type) ? dim : 1;
  return is_quadratic(type) ? 2 * dim - 1 : 2;
}

template <int dim, class Shape>
double volume_with(CellType type, std::span<const Vector<dim>> nodes, Shape& shape) {
  double volume = 0;
  for (const auto& point : gauss_rule<dim>(type, determinant_degree(type))) {
    shape_functions<dim>(type, point.xi, shape);
    Matrix<dim> jacobian = Matrix<dim>::Zero();
    for (std::size_t a = 0; a < nodes.size(); ++a) {
      jacobian += nodes[a] * shape.dN[a].transpose();
    }
    volume += jacobian.determinant() * point.weight;
  }
  return volume;
}

}  // namespace

template <int dim>
double cell_volume(CellType type, std::span<const Vector<dim>> nodes) {
  if (is_quadratic(type)) {
    AnyShapeValues<dim> shape;
    return volume_with<dim>(type, nodes, shape);
  }
  ShapeValues<dim> shape;
  return volume_with<dim>(type, nodes, shape);
}

template <int dim>
double cell_volume(const Mesh<dim>& mesh, std::int32_t c) {
  std::array<Vector<dim>, max_quadratic_nodes> nodes;
  const auto cell = mesh.cell(c);
  for (std::size_t a = 0; a < cell.size(); ++a) nodes[a] = mesh.nodes[cell[a]];
  return cell_volume<dim>(mesh.cell_type, std::span(nodes.data(), cell.size()));
}

namespace {

/// Types of cells of this dimension, the simplest first.
template <int dim>
std::vector<CellType> cell_types(CellOrders orders) {
  std::vector<CellType> types = {dim == 2 ? CellType::tri3 : CellType::tet4,
                                 dim == 2 ? CellType::quad4 : CellType::hex8};
  if (orders == CellOrders::linear) return types;
  for (const CellType type : {CellType::tri6, CellType::quad8, CellType::quad9, CellType::tet10,
                              CellType::hex20, CellType::hex27}) {
    if (dimension(type) == dim) types.push_back(type);
  }
  return types;
}

template <int dim>
CellType read_cell_type(ConfigReader& in, CellOrders orders) {
  const std::vector<CellType> types = cell_types<dim>(orders);
  std::vector<std::string> names;
  for (const CellType type : types) names.push_back(name(type));
  const std::string chosen = in.choice("type", names);
  return types[std::ranges::find(names, chosen) - names.begin()];
}

template <int dim>
BoxShape<dim> read_box(ConfigReader in, CellOrders orders) {
  BoxShape<dim> box;
  const auto low_values = in.vector("low", dim);
  const auto high_values = in.vector("high", dim);
  const auto cell_values = in.integers("cells", dim);
  for (int i = 0; i < dim; ++i) {
    box.low[i] = low_values[i];
    box.high[i] = high_values[i];
    box.num_cells[i] = cell_values[i];
    if (!(box.low[i] < box.high[i])) {
      in.fail("high", fmt::format("component {}: found {}, allowed: a number > low = {}", i,
                                  box.high[i], box.low[i]));
    }
  }
  box.cell_type = read_cell_type<dim>(in, orders);
  box.alternate = in.boolean_or("alternate", corner_type(box.cell_type) == CellType::tet4);
  if (box.alternate && !is_simplex(box.cell_type)) {
    in.fail("alternate", fmt::format("found true, allowed: only with type {}",
                                     name(dim == 2 ? CellType::tri3 : CellType::tet4)));
  }
  in.finish();
  return box;
}

KeyTable box_keys() {
  return {
      "box",
      "Box of equal cells. Its sides are the facet groups `left`, `right` (x), `bottom`, `top` "
      "(the last axis), in 3D also `front`, `back` (low and high y).",
      {key::vector("low", "m", "Corner with the smallest coordinates."),
       key::vector("high", "m", "Opposite corner; each component larger than that of `low`."),
       key::integers("cells", "Number of cells along each axis.").in(at_least(1)),
       key::choice(
           "type",
           {"tri3", "quad4", "tet4", "hex8", "tri6", "quad8", "quad9", "tet10", "hex20", "hex27"},
           "Cell type: in 2D `tri3` or `quad4`, in 3D `tet4` or `hex8`. Structures may have "
           "quadratic cells too: in 2D `tri6`, `quad8` or `quad9`, in 3D `tet10`, `hex20` or "
           "`hex27`."),
       key::boolean(
           "alternate",
           "Whether diagonals of triangles and tetrahedra change direction from cell to cell. No "
           "direction is favoured then where the numbers of cells are even; a brick has five "
           "tetrahedra instead of six.")
           .or_computed("true with `tet4` and `tet10`, else false")}};
}

}  // namespace

KeyTable mesh_keys() {
  return {"mesh",
          "A mesh of one cell type: tri3, quad4, tet4 or hex8; a structure may have quadratic "
          "cells too (tri6, quad8, quad9, tet10, hex20, hex27).",
          {key::text("file",
                     "Gmsh file, format 4.1, relative to the scene; its physical groups of "
                     "facets are the facet groups.")
               .or_none(),
           key::object("box", box_keys(), "Box of equal cells.").or_none()},
          {"file", "box"}};
}

template <int dim>
std::variant<BoxShape<dim>, std::string> read_box_or_file(ConfigReader in, CellOrders orders) {
  if (in.has("file") == in.has("box")) {
    in.fail("file", fmt::format("found {}, allowed: exactly one of \"file\" and \"box\"",
                                in.has("file") ? "both \"file\" and \"box\"" : "neither"));
  }
  if (in.has("box")) {
    auto box = in.object("box");
    in.finish();
    return read_box<dim>(box, orders);
  }
  std::string file = in.text("file");
  in.finish();
  return file;
}

namespace {

/// The mesh of a file of the scene; errors name the key.
template <class Read>
auto read_named_file(const ConfigReader& in, const std::string& file, const Read& read) {
  try {
    auto mesh = read();
    mesh.file = file;
    return mesh;
  } catch (const ConfigError& error) {
    in.fail("file", error.what());
  }
}

template <int dim>
Mesh<dim> mesh_of_box(const ConfigReader& in, const BoxShape<dim>& box) {
  try {
    return box_mesh<dim>(box.low, box.high, box.num_cells, box.cell_type, box.alternate);
  } catch (const ConfigError& error) {
    in.fail("box/cells", error.what());
  }
}

}  // namespace

template <int dim>
Mesh<dim> read_mesh_file(const Scene& scene, const ConfigReader& in, const std::string& file,
                         const LineGroupNames& lines, CellOrders orders) {
  return read_named_file(in, file, [&] { return read_gmsh<dim>(scene.path(file), lines, orders); });
}

template <int dim>
std::variant<BoxShape<dim>, Mesh<dim>> read_box_or_mesh(const Scene& scene, ConfigReader in) {
  const auto source = read_box_or_file<dim>(in);
  if (const auto* box = std::get_if<BoxShape<dim>>(&source)) return *box;
  return read_mesh_file<dim>(scene, in, std::get<std::string>(source));
}

template <int dim>
Mesh<dim> read_mesh(const Scene& scene, ConfigReader in, const LineGroupNames& lines,
                    CellOrders orders) {
  const auto read = read_box_or_file<dim>(in, orders);
  if (const auto* file = std::get_if<std::string>(&read)) {
    return read_mesh_file<dim>(scene, in, *file, lines, orders);
  }
  return mesh_of_box(in, std::get<BoxShape<dim>>(read));
}

template <int dim>
Mesh<dim> read_surface_mesh(const Scene& scene, ConfigReader in,
                            const std::vector<std::string>& groups) {
  const auto read = read_box_or_file<dim>(in);
  if (const auto* file = std::get_if<std::string>(&read)) {
    return read_named_file(in, *file,
                           [&] { return read_gmsh_surface<dim>(scene.path(*file), groups); });
  }
  return mesh_of_box(in, std::get<BoxShape<dim>>(read));
}

template <int dim>
void warn_of_cell_groups(const Mesh<dim>& mesh, const std::string& where) {
  if (mesh.cell_groups.size() < 2) return;
  std::vector<std::string> names;
  for (const auto& [name, cells] : mesh.cell_groups) names.push_back(name);
  log::warn("{}: nothing tells the cell groups {} of {} apart: all cells get one material", where,
            fmt::join(names, ", "), mesh.file);
}

template struct Mesh<2>;
template struct Mesh<3>;
template double cell_volume<2>(CellType, std::span<const Vector<2>>);
template double cell_volume<3>(CellType, std::span<const Vector<3>>);
template double cell_volume(const Mesh<2>&, std::int32_t);
template double cell_volume(const Mesh<3>&, std::int32_t);
template std::variant<BoxShape<2>, std::string> read_box_or_file<2>(ConfigReader, CellOrders);
template std::variant<BoxShape<3>, std::string> read_box_or_file<3>(ConfigReader, CellOrders);
template Mesh<2> read_mesh_file(const Scene&, const ConfigReader&, const std::string&,
                                const LineGroupNames&, CellOrders);
template Mesh<3> read_mesh_file(const Scene&, const ConfigReader&, const std::string&,
                                const LineGroupNames&, CellOrders);
template std::variant<BoxShape<2>, Mesh<2>> read_box_or_mesh(const Scene&, ConfigReader);
template std::variant<BoxShape<3>, Mesh<3>> read_box_or_mesh(const Scene&, ConfigReader);
template Mesh<2> read_mesh(const Scene&, ConfigReader, const LineGroupNames&, CellOrders);
template Mesh<3> read_mesh(const Scene&, ConfigReader, const LineGroupNames&, CellOrders);
template Mesh<2> read_surface_mesh(const Scene&, ConfigReader, const std::vector<std::string>&);
template Mesh<3> read_surface_mesh(const Scene&, ConfigReader, const std::vector<std::string>&);
template void warn_of_cell_groups(const Mesh<2>&, const std::string&);
template void warn_of_cell_groups(const Mesh<3>&, const std::string&);

}  // namespace gabion
