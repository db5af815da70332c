// SPDX-License-Identifier: BSD-3-Clause
#include "common/mechanics/mesh/mesh.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/LU>
#include <algorithm>

#include "common/base/error.hpp"
#include "common/base/log.hpp"
#include "common/mechanics/elements/shape_functions.hpp"

namespace gabion {

template <int dim>
const std::vector<std::int32_t>& Mesh<dim>::facets(const std::string& group,
                                                   const std::string& where) const {
  const auto found = facet_groups.find(group);
  if (found != facet_groups.end()) return found->second;
  std::vector<std::string> names;
  for (const auto& [known, facets] : facet_groups) names.push_back(known);
  throw ConfigError(
      fmt::format("{}: found facet group \"{}\", the mesh has: {}", where, group,
                  names.empty() ? "none" : fmt::format("{}", fmt::join(names, ", "))));
}

template <int dim>
std::vector<std::int32_t> Mesh<dim>::group_nodes(const std::string& group,
                                                 const std::string& where) const {
  std::vector<std::int32_t> result = facets(group, where);
  std::sort(result.begin(), result.end());
  result.erase(std::unique(result.begin(), result.end()), result.end());
  return result;
}

template <int dim>
double cell_volume(const Mesh<dim>& mesh, std::int32_t c) {
  // det(dx/dxi) is constant in simplices, of degree 1 (quad4) or 2 (hex8) in each coordinate.
  const bool affine = mesh.cell_type == CellType::tri3 || mesh.cell_type == CellType::tet4;
  const auto cell = mesh.cell(c);
  ShapeValues<dim> shape;
  double volume = 0;
  for (const auto& point : gauss_rule<dim>(mesh.cell_type, affine ? 1 : 2)) {
    shape_functions<dim>(mesh.cell_type, point.xi, shape);
    Matrix<dim> jacobian = Matrix<dim>::Zero();
    for (std::size_t a = 0; a < cell.size(); ++a) {
      jacobian += mesh.nodes[cell[a]] * shape.dN[a].transpose();
    }
    volume += jacobian.determinant() * point.weight;
  }
  return volume;
}

namespace {

template <int dim>
Mesh<dim> read_box(ConfigReader in) {
  Vector<dim> low, high;
  Eigen::Matrix<int, dim, 1> num_cells;
  const auto low_values = in.vector("low", dim);
  const auto high_values = in.vector("high", dim);
  const auto cell_values = in.integers("cells", dim);
  for (int i = 0; i < dim; ++i) {
    low[i] = low_values[i];
    high[i] = high_values[i];
    num_cells[i] = cell_values[i];
    if (!(low[i] < high[i])) {
      in.fail("high", fmt::format("component {}: found {}, allowed: a number > low = {}", i,
                                  high[i], low[i]));
    }
  }
  const CellType simplex = dim == 2 ? CellType::tri3 : CellType::tet4;
  const CellType brick = dim == 2 ? CellType::quad4 : CellType::hex8;
  const bool cut = in.choice("type", {name(simplex), name(brick)}) == name(simplex);
  const bool alternate = in.boolean("alternate");
  if (alternate && !cut) {
    in.fail("alternate", fmt::format("found true, allowed: only with type {}", name(simplex)));
  }
  in.finish();
  try {
    return box_mesh<dim>(low, high, num_cells, cut ? simplex : brick, alternate);
  } catch (const ConfigError& error) {
    in.fail("cells", error.what());
  }
}

KeyTable box_keys() {
  return {"box",
          "Box of equal cells. Its sides are the facet groups `left`, `right` (x), `bottom`, `top` "
          "(the last axis), in 3D also `front`, `back` (low and high y).",
          {key::vector("low", "m", "Corner with the smallest coordinates."),
           key::vector("high", "m", "Opposite corner; each component larger than that of `low`."),
           key::integers("cells", "Number of cells along each axis.").in(at_least(1)),
           key::choice("type", {"tri3", "quad4", "tet4", "hex8"},
                       "Cells: in 2D `tri3` or `quad4`, in 3D `tet4` or `hex8`."),
           key::boolean("alternate",
                        "Diagonals of `tri3` and `tet4` change direction from cell to cell; five "
                        "tetrahedra a brick instead of six.")
               .or_else(false)}};
}

}  // namespace

KeyTable mesh_keys() {
  return {"mesh",
          "A mesh of one cell type (tri3, quad4, tet4, hex8).",
          {key::text("file",
                     "Gmsh file, format 4.1, relative to the scene; its physical groups of "
                     "facets are the facet groups.")
               .or_none(),
           key::object("box", box_keys(), "Box of equal cells.").or_none()},
          {"file", "box"}};
}

template <int dim>
Mesh<dim> read_mesh(const Scene& scene, ConfigReader in) {
  if (in.has("file") == in.has("box")) {
    in.fail("file", fmt::format("found {}, allowed: exactly one of \"file\" and \"box\"",
                                in.has("file") ? "both \"file\" and \"box\"" : "neither"));
  }
  if (in.has("box")) {
    auto box = in.object("box");
    in.finish();
    return read_box<dim>(box);
  }
  const std::string file = in.text("file");
  in.finish();
  try {
    Mesh<dim> mesh = read_gmsh<dim>(scene.path(file));
    mesh.file = file;
    return mesh;
  } catch (const ConfigError& error) {
    in.fail("file", error.what());
  }
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
template double cell_volume(const Mesh<2>&, std::int32_t);
template double cell_volume(const Mesh<3>&, std::int32_t);
template Mesh<2> read_mesh(const Scene&, ConfigReader);
template Mesh<3> read_mesh(const Scene&, ConfigReader);
template void warn_of_cell_groups(const Mesh<2>&, const std::string&);
template void warn_of_cell_groups(const Mesh<3>&, const std::string&);

}  // namespace gabion
