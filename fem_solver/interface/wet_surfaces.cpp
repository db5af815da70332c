// SPDX-License-Identifier: BSD-3-Clause
#include "fem_solver/interface/wet_surfaces.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "common/base/require.hpp"

namespace gabion::fem {

namespace {

template <int dim>
std::vector<std::int32_t> facets_of(const Mesh<dim>& mesh, const WetSurfaceSettings& settings) {
  std::vector<std::int32_t> facets;
  for (const auto& group : settings.groups) {
    const auto& part = mesh.facets(group, settings.where);
    facets.insert(facets.end(), part.begin(), part.end());
  }
  return facets;
}

}  // namespace

template <int dim>
WetSurfaces<dim>::WetSurfaces(const Mesh<dim>& structure,
                              const std::vector<WetSurfaceSettings>& interfaces)
    : num_dofs_(structure.nodes.size() * dim) {
  for (const auto& interface : interfaces) {
    const auto facets = facets_of(structure, interface);
    std::vector<std::int32_t> nodes = facets;
    std::sort(nodes.begin(), nodes.end());
    nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());

    InterfaceMesh mesh;
    mesh.name = interface.name;
    mesh.dim = dim;
    mesh.vertices_per_facet = num_nodes(facet_type(structure.cell_type));
    for (const auto node : nodes) {
      const Vector<dim>& x = structure.nodes[node];
      mesh.coordinates.insert(mesh.coordinates.end(), x.data(), x.data() + dim);
    }
    for (const auto node : facets) {
      mesh.facets.push_back(std::lower_bound(nodes.begin(), nodes.end(), node) - nodes.begin());
    }
    meshes_.push_back(std::move(mesh));
    nodes_.push_back(std::move(nodes));
    kinds_.push_back(ForceKind::end_of_step);
  }
}

template <int dim>
void WetSurfaces<dim>::set_force_kinds(const ForceKinds& kinds) {
  kinds_.assign(meshes_.size(), ForceKind::end_of_step);
  for (const auto& [name, kind] : kinds) {
    const auto found = std::find_if(meshes_.begin(), meshes_.end(),
                                    [&](const InterfaceMesh& mesh) { return mesh.name == name; });
    require(found != meshes_.end(), "kinds of forces: found interface \"{}\", which is none here",
            name);
    kinds_[static_cast<std::size_t>(found - meshes_.begin())] = kind;
  }
}

template <int dim>
ExternalForces WetSurfaces<dim>::nodal_forces(const InterfaceValues& received) const {
  if (received.empty()) return {};
  require(received.size() == meshes_.size(), "received forces of {} interfaces, expected {}",
          received.size(), meshes_.size());
  ExternalForces forces;
  forces.end.assign(num_dofs_, 0.0);
  forces.step.assign(num_dofs_, 0.0);
  for (std::size_t s = 0; s < meshes_.size(); ++s) {
    const auto found = received.find(meshes_[s].name);
    require(found != received.end(), "received no forces of interface \"{}\"", meshes_[s].name);
    const auto& values = found->second;
    require(values.size() == nodes_[s].size() * dim,
            "interface \"{}\": received {} force values, expected {} vertices x {}",
            meshes_[s].name, values.size(), nodes_[s].size(), dim);
    auto& f = kinds_[s] == ForceKind::step_mean ? forces.step : forces.end;
    for (std::size_t k = 0; k < nodes_[s].size(); ++k) {
      for (int c = 0; c < dim; ++c) {
        f[static_cast<std::size_t>(nodes_[s][k]) * dim + c] += values[k * dim + c];
      }
    }
  }
  return forces;
}

template <int dim>
InterfaceValues WetSurfaces<dim>::displacements(std::span<const double> u) const {
  InterfaceValues result;
  for (std::size_t s = 0; s < meshes_.size(); ++s) {
    auto& values = result[meshes_[s].name];
    for (const auto node : nodes_[s]) {
      const auto* first = u.data() + static_cast<std::size_t>(node) * dim;
      values.insert(values.end(), first, first + dim);
    }
  }
  return result;
}

template class WetSurfaces<2>;
template class WetSurfaces<3>;

}  // namespace gabion::fem
