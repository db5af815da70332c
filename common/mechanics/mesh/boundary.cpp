// SPDX-License-Identifier: BSD-3-Clause
#include "common/mechanics/mesh/boundary.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cassert>
#include <limits>
#include <utility>

#include "common/base/require.hpp"
#include "common/mechanics/elements/cell_facets.hpp"

namespace gabion {

FacetOwners::Key FacetOwners::key(std::span<const std::int32_t> nodes) const {
  assert(nodes.size() == num_nodes_);
  Key result;
  result.fill(std::numeric_limits<std::int32_t>::max());
  std::copy_n(nodes.begin(), num_corners_, result.begin());
  for (const auto& [i, j] : {std::pair{0, 1}, {2, 3}, {0, 2}, {1, 3}, {1, 2}}) {
    if (result[j] < result[i]) std::swap(result[i], result[j]);
  }
  return result;
}

template <int dim>
FacetOwners::FacetOwners(const Mesh<dim>& mesh)
    : num_nodes_(num_nodes(facet_type(mesh.cell_type))),
      num_corners_(num_corners(facet_type(mesh.cell_type))) {
  const int facets_per_cell = num_facets(mesh.cell_type);
  const int n = num_nodes(facet_type(mesh.cell_type));
  struct Entry {
    Key key;
    Owner owner;
  };
  std::vector<Entry> entries;
  entries.reserve(static_cast<std::size_t>(mesh.num_cells()) * facets_per_cell);
  for (std::int32_t c = 0; c < mesh.num_cells(); ++c) {
    for (int f = 0; f < facets_per_cell; ++f) {
      const auto nodes = cell_facet(mesh, c, f);
      entries.push_back({key({nodes.data(), static_cast<std::size_t>(n)}), {c, f}});
    }
  }
  std::stable_sort(entries.begin(), entries.end(),
                   [](const Entry& a, const Entry& b) { return a.key < b.key; });
  keys_.reserve(entries.size());
  owners_.reserve(entries.size());
  for (const Entry& entry : entries) {
    keys_.push_back(entry.key);
    owners_.push_back(entry.owner);
  }
}

std::span<const FacetOwners::Owner> FacetOwners::find(std::span<const std::int32_t> nodes) const {
  if (nodes.size() != num_nodes_) return {};
  const auto [first, last] = std::equal_range(keys_.begin(), keys_.end(), key(nodes));
  return {owners_.data() + (first - keys_.begin()), static_cast<std::size_t>(last - first)};
}

template <int dim>
std::array<std::int32_t, max_facet_nodes> cell_facet(const Mesh<dim>& mesh, std::int32_t c, int f) {
  std::array<std::int32_t, max_facet_nodes> result;
  result.fill(-1);
  const auto cell = mesh.cell(c);
  const auto local = facet_nodes(mesh.cell_type, f);
  for (std::size_t a = 0; a < local.size(); ++a) result[a] = cell[local[a]];
  return result;
}

template <int dim>
std::vector<std::int32_t> cell_neighbours(const Mesh<dim>& mesh) {
  const FacetOwners owners(mesh);
  const int facets_per_cell = num_facets(mesh.cell_type);
  const std::size_t n = num_nodes(facet_type(mesh.cell_type));
  std::vector<std::int32_t> result(static_cast<std::size_t>(mesh.num_cells()) * facets_per_cell,
                                   -1);
  for (std::int32_t c = 0; c < mesh.num_cells(); ++c) {
    for (int f = 0; f < facets_per_cell; ++f) {
      const auto nodes = cell_facet(mesh, c, f);
      const auto found = owners.find({nodes.data(), n});
      require<ConfigError>(found.size() <= 2,
                           "mesh: found {} cells that share one facet of cell {}, "
                           "allowed: at most two",
                           found.size(), c);
      if (found.size() == 2) {
        result[static_cast<std::size_t>(c) * facets_per_cell + f] =
            found[0].cell == c ? found[1].cell : found[0].cell;
      }
    }
  }
  return result;
}

template <int dim>
std::vector<std::int32_t> boundary_facets(const Mesh<dim>& mesh) {
  const auto neighbours = cell_neighbours(mesh);
  const int facets_per_cell = num_facets(mesh.cell_type);
  const int n = num_nodes(facet_type(mesh.cell_type));
  std::vector<std::int32_t> result;
  for (std::int32_t c = 0; c < mesh.num_cells(); ++c) {
    for (int f = 0; f < facets_per_cell; ++f) {
      if (neighbours[static_cast<std::size_t>(c) * facets_per_cell + f] >= 0) continue;
      const auto nodes = cell_facet(mesh, c, f);
      result.insert(result.end(), nodes.begin(), nodes.begin() + n);
    }
  }
  return result;
}

template <int dim>
std::vector<Vector<dim>> facet_area_vectors(std::span<const Vector<dim>> x, CellType type,
                                            std::span<const std::int32_t> facets) {
  assert(dimension(type) == dim - 1 && !is_quadratic(type));
  const std::size_t n = num_nodes(type);
  std::vector<Vector<dim>> result(facets.size() / n);
  for (std::size_t f = 0; f < result.size(); ++f) {
    const std::int32_t* a = &facets[f * n];
    if constexpr (dim == 2) {
      const Vector<2> edge = x[a[1]] - x[a[0]];
      result[f] = Vector<2>(edge[1], -edge[0]);
    } else if (type == CellType::tri3) {
      result[f] = 0.5 * (x[a[1]] - x[a[0]]).cross(x[a[2]] - x[a[0]]);
    } else {
      result[f] = 0.5 * (x[a[2]] - x[a[0]]).cross(x[a[3]] - x[a[1]]);
    }
  }
  return result;
}

template <int dim>
std::vector<FacetGeometry<dim>> facet_geometry(std::span<const Vector<dim>> x, CellType type,
                                               std::span<const std::int32_t> facets) {
  const auto area_vectors = facet_area_vectors<dim>(x, type, facets);
  std::vector<FacetGeometry<dim>> result;
  result.reserve(area_vectors.size());
  for (const auto& vector : area_vectors) {
    const double area = vector.norm();
    require(area > 0, "facet {} has no area", result.size());
    result.push_back({vector / area, area});
  }
  return result;
}

template FacetOwners::FacetOwners(const Mesh<2>&);
template FacetOwners::FacetOwners(const Mesh<3>&);
template std::array<std::int32_t, max_facet_nodes> cell_facet(const Mesh<2>&, std::int32_t, int);
template std::array<std::int32_t, max_facet_nodes> cell_facet(const Mesh<3>&, std::int32_t, int);
template std::vector<std::int32_t> cell_neighbours(const Mesh<2>&);
template std::vector<std::int32_t> cell_neighbours(const Mesh<3>&);
template std::vector<std::int32_t> boundary_facets(const Mesh<2>&);
template std::vector<std::int32_t> boundary_facets(const Mesh<3>&);
template std::vector<Vector<2>> facet_area_vectors<2>(std::span<const Vector<2>>, CellType,
                                                      std::span<const std::int32_t>);
template std::vector<Vector<3>> facet_area_vectors<3>(std::span<const Vector<3>>, CellType,
                                                      std::span<const std::int32_t>);
template std::vector<FacetGeometry<2>> facet_geometry<2>(std::span<const Vector<2>>, CellType,
                                                         std::span<const std::int32_t>);
template std::vector<FacetGeometry<3>> facet_geometry<3>(std::span<const Vector<3>>, CellType,
                                                         std::span<const std::int32_t>);

}  // namespace gabion
