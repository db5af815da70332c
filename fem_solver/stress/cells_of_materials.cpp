// SPDX-License-Identifier: BSD-3-Clause
#include "fem_solver/stress/cells_of_materials.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <numeric>
#include <string>

#include "common/base/require.hpp"
#include "common/mechanics/elements/cell_facets.hpp"
#include "common/mechanics/mesh/boundary.hpp"

namespace gabion::fem {

namespace {

template <int dim>
const std::vector<std::int32_t>& find_cells(const Mesh<dim>& mesh,
                                            const CellMaterial<dim>& material) {
  const auto found = mesh.cell_groups.find(material.group);
  if (found != mesh.cell_groups.end()) return found->second;
  std::vector<std::string> names;
  for (const auto& [name, cells] : mesh.cell_groups) names.push_back(name);
  throw ConfigError(
      fmt::format("{}: found cell group \"{}\", {} has: {}", material.where, material.group,
                  mesh.file.empty() ? "a box" : mesh.file,
                  names.empty() ? "none" : fmt::format("{}", fmt::join(names, ", "))));
}

template <int dim>
std::string centre_text(const Mesh<dim>& mesh, std::span<const std::int32_t> nodes) {
  Vector<dim> centre = Vector<dim>::Zero();
  for (const std::int32_t i : nodes) centre += mesh.nodes[i] / static_cast<int>(nodes.size());
  return fmt::format("({:.6g})", fmt::join(centre.data(), centre.data() + dim, ", "));
}

template <int dim>
const std::vector<std::int32_t>& find_lines(const Mesh<dim>& mesh, const LineMaterial& material) {
  const auto found = mesh.line_groups.find(material.group);
  if (found != mesh.line_groups.end()) return found->second;
  std::vector<std::string> names;
  for (const auto& [name, nodes] : mesh.node_groups) names.push_back(name);
  for (const auto& [name, facets] : mesh.facet_groups) {
    if (dim == 2) names.push_back(name);
  }
  throw ConfigError(fmt::format(
      "{}: found \"law\" \"{}\" of group \"{}\", which is none of lines; allowed: a physical group "
      "of curves; {} has beside cells: {}",
      material.where, material.law_name, material.group, mesh.file.empty() ? "a box" : mesh.file,
      names.empty() ? "none" : fmt::format("{}", fmt::join(names, ", "))));
}

}  // namespace

template <int dim>
std::string describe_cell(const Mesh<dim>& mesh, const MeshRanks& ranks, std::int32_t c) {
  return fmt::format("cell {} near {}", ranks.cell_of_all(c), centre_text(mesh, mesh.cell(c)));
}

bool is_shared(std::span<const std::int32_t> facet, const SharedNodes& shared) {
  if (shared.alone()) return false;
  const auto has_all = [&](int n) {
    const auto nodes = shared.shared_with(n);
    return std::ranges::all_of(
        facet, [&](std::int32_t i) { return std::ranges::find(nodes, i) != nodes.end(); });
  };
  for (int n = 0; n < shared.num_neighbours(); ++n) {
    if (has_all(n)) return true;
  }
  return false;
}

template <int dim>
void refuse_loose_cells(const Mesh<dim>& mesh, std::span<const CellMaterial<dim>> materials,
                        const MeshRanks& ranks) {
  if (mesh.cell_type != CellType::hex20) return;
  const auto neighbours = cell_neighbours(mesh);
  const auto goes_on = [&](std::int32_t c, int axis, int end) {
    const int f = brick_facet(3, axis, end);
    if (neighbours[static_cast<std::size_t>(c) * 6 + f] >= 0) return true;
    const auto facet = cell_facet(mesh, c, f);
    return is_shared(std::span(facet).first(4), ranks.shared());
  };
  for (const auto& material : materials) {
    if (material.formulation != Formulation::reduced) continue;
    const auto cells = cells_of_materials<dim>(mesh, materials, ranks);
    for (const std::int32_t c : cells[&material - materials.data()]) {
      int axes = 0;
      for (int axis = 0; axis < 3; ++axis) axes += goes_on(c, axis, 0) || goes_on(c, axis, 1);
      require<ConfigError>(axes >= 2, [&] {
        return fmt::format(
            "{}: found \"formulation\" \"reduced\" with {}, which has neighbours along {} of its "
            "axes: it keeps a mode without energy, allowed: hex20 with neighbours along two, or "
            "\"full\"",
            material.where, describe_cell(mesh, ranks, c), axes);
      });
    }
  }
}

template <int dim>
std::vector<std::vector<std::int32_t>> lines_of_materials(const Mesh<dim>& mesh,
                                                          std::span<const LineMaterial> materials,
                                                          const MeshRanks& ranks) {
  std::vector<std::vector<std::int32_t>> lines;
  std::vector<const LineMaterial*> of_line(mesh.num_lines(), nullptr);
  for (const LineMaterial& material : materials) {
    lines.push_back(find_lines(mesh, material));
    for (const std::int32_t l : lines.back()) {
      require<ConfigError>(of_line[l] == nullptr, [&] {
        return fmt::format(
            "{}: found line {} near {} of {} in the groups \"{}\" and \"{}\", allowed: each line "
            "in "
            "one group of \"materials\"",
            material.where, ranks.line_of_all(l), centre_text(mesh, mesh.line(l)), mesh.file,
            of_line[l]->group, material.group);
      });
      of_line[l] = &material;
    }
  }
  return lines;
}

template <int dim>
std::vector<std::vector<std::int32_t>> cells_of_materials(
    const Mesh<dim>& mesh, std::span<const CellMaterial<dim>> materials, const MeshRanks& ranks) {
  std::vector<std::vector<std::int32_t>> cells(materials.size());
  if (materials.size() == 1 && materials[0].group.empty()) {
    cells[0].resize(mesh.num_cells());
    std::iota(cells[0].begin(), cells[0].end(), 0);
    return cells;
  }
  constexpr std::size_t none = -1;
  std::vector<std::size_t> of_cell(mesh.num_cells(), none);
  for (std::size_t m = 0; m < materials.size(); ++m) {
    for (const std::int32_t c : find_cells(mesh, materials[m])) {
      require<ConfigError>(of_cell[c] == none, [&] {
        return fmt::format(
            "{}: found {} of {} in the groups \"{}\" and \"{}\", allowed: each cell "
            "in one group of \"materials\"",
            materials[m].where, describe_cell(mesh, ranks, c), mesh.file,
            materials[of_cell[c]].group, materials[m].group);
      });
      of_cell[c] = m;
    }
  }
  for (std::int32_t c = 0; c < mesh.num_cells(); ++c) {
    require<ConfigError>(of_cell[c] != none, [&] {
      const auto missing = std::ranges::count(of_cell, none);
      return fmt::format(
          "{}: found {} of {} in no group of \"materials\" ({} such cells), allowed: "
          "each cell in one of them",
          materials[0].where, describe_cell(mesh, ranks, c), mesh.file, missing);
    });
    cells[of_cell[c]].push_back(c);
  }
  return cells;
}

template std::string describe_cell(const Mesh<2>&, const MeshRanks&, std::int32_t);
template std::string describe_cell(const Mesh<3>&, const MeshRanks&, std::int32_t);

template void refuse_loose_cells(const Mesh<2>&, std::span<const CellMaterial<2>>,
                                 const MeshRanks&);
template void refuse_loose_cells(const Mesh<3>&, std::span<const CellMaterial<3>>,
                                 const MeshRanks&);

template std::vector<std::vector<std::int32_t>> cells_of_materials(const Mesh<2>&,
                                                                   std::span<const CellMaterial<2>>,
                                                                   const MeshRanks&);
template std::vector<std::vector<std::int32_t>> cells_of_materials(const Mesh<3>&,
                                                                   std::span<const CellMaterial<3>>,
                                                                   const MeshRanks&);

template std::vector<std::vector<std::int32_t>> lines_of_materials(const Mesh<2>&,
                                                                   std::span<const LineMaterial>,
                                                                   const MeshRanks&);
template std::vector<std::vector<std::int32_t>> lines_of_materials(const Mesh<3>&,
                                                                   std::span<const LineMaterial>,
                                                                   const MeshRanks&);

}  // namespace gabion::fem
