// SPDX-License-Identifier: BSD-3-Clause
#include "fem_solver/interface/exposed_facets.hpp"

#include <algorithm>

#include "common/mechanics/elements/cell_facets.hpp"
#include "common/mechanics/mesh/boundary.hpp"

namespace gabion::fem {

namespace {

/// The owner whose outward face is turned as the facet is; -1: none.
template <int dim>
std::int32_t cell_under(const Mesh<dim>& mesh, std::span<const FacetOwners::Owner> owners,
                        std::span<const std::int32_t> facet) {
  for (const auto& owner : owners) {
    auto face = cell_facet(mesh, owner.cell, owner.facet);
    const auto end = face.begin() + static_cast<std::ptrdiff_t>(facet.size());
    const auto first = std::find(face.begin(), end, facet.front());
    if (first == end) continue;
    std::rotate(face.begin(), first, end);
    if (std::equal(facet.begin(), facet.end(), face.begin())) return owner.cell;
  }
  return -1;
}

}  // namespace

template <int dim>
ExposedFacets<dim>::ExposedFacets(const Mesh<dim>& mesh, std::span<const std::int64_t> facets,
                                  std::span<const std::int32_t> leaving)
    : mesh_(mesh),
      facets_(facets.begin(), facets.end()),
      leaving_(static_cast<std::size_t>(mesh.num_cells()), 0),
      neighbours_(cell_neighbours(mesh)) {
  for (const std::int32_t c : leaving) leaving_[c] = 1;
  const FacetOwners owners(mesh);
  const std::size_t n = num_nodes(facet_type(mesh.cell_type));
  for (std::size_t f = 0; f < facets_.size(); f += n) {
    const std::vector<std::int32_t> facet(facets_.begin() + static_cast<std::ptrdiff_t>(f),
                                          facets_.begin() + static_cast<std::ptrdiff_t>(f + n));
    const std::int32_t cell = cell_under(mesh, owners.find(facet), std::span(facet));
    cells_.push_back(cell >= 0 && leaving_[cell] != 0 ? cell : -1);
  }
}

/// Cells that are gone and to which soil comes, ascending.
template <int dim>
std::vector<std::int32_t> ExposedFacets<dim>::open_cells(std::span<const char> gone) const {
  std::vector<char> seen(leaving_.size(), 0);
  std::vector<std::int32_t> open;
  const auto visit = [&](std::int32_t cell) {
    if (!has_left(cell, gone) || seen[cell] != 0) return;
    seen[cell] = 1;
    open.push_back(cell);
  };
  for (const std::int32_t cell : cells_) visit(cell);
  const int faces = num_facets(mesh_.cell_type);
  for (std::size_t k = 0; k < open.size(); ++k) {
    for (int f = 0; f < faces; ++f) visit(neighbours_[std::size_t(open[k]) * faces + f]);
  }
  std::ranges::sort(open);
  return open;
}

template <int dim>
std::vector<std::int64_t> ExposedFacets<dim>::facets(std::span<const char> gone) const {
  const std::size_t n = num_nodes(facet_type(mesh_.cell_type));
  std::vector<std::int64_t> result;
  for (std::size_t f = 0; f < cells_.size(); ++f) {
    if (has_left(cells_[f], gone)) continue;
    const auto first = facets_.begin() + static_cast<std::ptrdiff_t>(f * n);
    result.insert(result.end(), first, first + static_cast<std::ptrdiff_t>(n));
  }
  const int faces = num_facets(mesh_.cell_type);
  for (const std::int32_t cell : open_cells(gone)) {
    for (int f = 0; f < faces; ++f) {
      const std::int32_t behind = neighbours_[std::size_t(cell) * faces + f];
      if (behind < 0 || has_left(behind, gone)) continue;
      auto face = cell_facet(mesh_, cell, f);
      std::reverse(face.begin(), face.begin() + static_cast<std::ptrdiff_t>(n));
      result.insert(result.end(), face.begin(), face.begin() + static_cast<std::ptrdiff_t>(n));
    }
  }
  return result;
}

template class ExposedFacets<2>;
template class ExposedFacets<3>;

}  // namespace gabion::fem
