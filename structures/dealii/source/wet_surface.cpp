// SPDX-License-Identifier: BSD-3-Clause
#include "wet_surface.hpp"

#include <deal.II/dofs/dof_tools.h>
#include <deal.II/fe/fe_tools.h>
#include <deal.II/fe/mapping_q1.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "mesh.hpp"

namespace dealii_structure {

namespace {

template <int dim>
using Place = std::array<std::int64_t, dim>;
template <int dim>
using Facet = std::array<std::int64_t, 2 * (dim - 1)>;

/// Nodes of a face in rows along its first, then its second direction.
template <int dim>
class FaceNodes {
 public:
  explicit FaceNodes(const dealii::FiniteElement<dim>& element)
      : element_(element),
        row_place_(dealii::FETools::hierarchic_to_lexicographic_numbering<dim - 1>(element.degree)),
        dofs_(element.n_dofs_per_face()) {}

  template <class Face>
  std::vector<std::array<unsigned, dim>> of(const Face& face) {
    face->get_dof_indices(dofs_, 0);
    std::vector<std::array<unsigned, dim>> nodes(row_place_.size());
    for (unsigned i = 0; i < dofs_.size(); ++i) {
      const auto [component, node] = element_.face_system_to_component_index(i);
      nodes[row_place_[node]][component] = dofs_[i];
    }
    return nodes;
  }

 private:
  const dealii::FiniteElement<dim>& element_;
  std::vector<unsigned> row_place_;
  std::vector<unsigned> dofs_;
};

/// The linear facets between the nodes of a face, as numbers of nodes.
template <int dim>
std::vector<Facet<dim>> pieces(std::int64_t degree) {
  std::vector<Facet<dim>> all;
  for (std::int64_t i = 0; i < degree; ++i) {
    if constexpr (dim == 2) {
      all.push_back({i, i + 1});
    } else {
      for (std::int64_t j = 0; j < degree; ++j) {
        const std::int64_t first = i * (degree + 1) + j;
        all.push_back({first, first + 1, first + degree + 2, first + degree + 1});
      }
    }
  }
  return all;
}

template <int dim>
dealii::Point<dim> vertex(const gabion::InterfaceMesh& mesh, std::int64_t k) {
  dealii::Point<dim> point;
  for (int i = 0; i < dim; ++i) point[i] = mesh.coordinates[k * dim + i];
  return point;
}

/// Turn the facet round where its normal points into the solid.
template <int dim>
void orient(const gabion::InterfaceMesh& mesh, const dealii::Point<dim>& inside,
            Facet<dim>& facet) {
  const auto first = vertex<dim>(mesh, facet[0]), second = vertex<dim>(mesh, facet[1]);
  dealii::Tensor<1, dim> normal;
  if constexpr (dim == 2) {
    normal[0] = second[1] - first[1];
    normal[1] = first[0] - second[0];
  } else {
    normal = cross_product_3d(second - first, vertex<dim>(mesh, facet[3]) - first);
  }
  if (normal * (first - inside) < 0) std::reverse(facet.begin(), facet.end());
}

}  // namespace

template <int dim>
WetSurface<dim>::WetSurface(const Settings& settings, const InterfaceSettings& interface,
                            const ElasticSolid<dim>& solid) {
  mesh_.name = interface.name;
  mesh_.dim = dim;
  mesh_.vertices_per_facet = 2 * (dim - 1);
  const auto wet = boundary_ids(settings, solid.mesh(), interface.groups);
  std::vector<dealii::Point<dim>> points(solid.num_dofs());
  dealii::DoFTools::map_dofs_to_support_points(dealii::MappingQ1<dim>(), solid.dofs(), points);
  std::map<Place<dim>, std::int64_t> known;
  FaceNodes<dim> face_nodes(solid.dofs().get_fe());
  const auto vertex_of = [&](const std::array<unsigned, dim>& dofs, double size) {
    Place<dim> place;
    // A quarter keeps the nodes, which are at multiples, away from where rounding jumps.
    for (int i = 0; i < dim; ++i) {
      place[i] = std::llround((points[dofs[0]][i] - points[0][i]) / size + 0.25);
    }
    const auto [entry, is_new] = known.emplace(place, dofs_.size());
    if (is_new) {
      dofs_.push_back(dofs);
      for (int i = 0; i < dim; ++i) mesh_.coordinates.push_back(points[dofs[0]][i]);
    }
    return entry->second;
  };
  double smallest = std::numeric_limits<double>::max();
  for (const auto& cell : solid.mesh().active_cell_iterators()) {
    smallest = std::min(smallest, cell->minimum_vertex_distance());
  }
  for (const auto& cell : solid.dofs().active_cell_iterators()) {
    for (const auto& face : cell->face_iterators()) {
      if (!face->at_boundary() || !wet.contains(face->boundary_id())) continue;
      const auto nodes = face_nodes.of(face);
      for (Facet<dim> facet : pieces<dim>(settings.degree)) {
        for (auto& k : facet) k = vertex_of(nodes[k], 1e-4 * smallest);
        orient<dim>(mesh_, cell->center(), facet);
        mesh_.facets.insert(mesh_.facets.end(), facet.begin(), facet.end());
      }
    }
  }
}

template <int dim>
void WetSurface<dim>::add_forces(std::span<const double> values, Vector& f) const {
  for (std::size_t k = 0; k < dofs_.size(); ++k) {
    for (int i = 0; i < dim; ++i) f[dofs_[k][i]] += values[k * dim + i];
  }
}

template <int dim>
std::vector<double> WetSurface<dim>::displacement(const Vector& u) const {
  std::vector<double> values;
  values.reserve(dofs_.size() * dim);
  for (const auto& dofs : dofs_) {
    for (const unsigned dof : dofs) values.push_back(u[dof]);
  }
  return values;
}

template class WetSurface<2>;
template class WetSurface<3>;

}  // namespace dealii_structure
