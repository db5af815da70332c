// SPDX-License-Identifier: BSD-3-Clause
#include "fem_solver/interface/beam_surfaces.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "common/base/require.hpp"
#include "fem_solver/interface/beam_outline.hpp"

namespace gabion::fem {

template <int dim>
std::vector<Matrix<dim>> beam_turns(const FemSettings<dim>& settings,
                                    const CellIntegrals<dim>& cells, std::span<const double> u,
                                    std::span<const double> history) {
  const std::int32_t places = settings.num_places();
  std::vector<Matrix<dim>> turns(settings.mesh.nodes.size() - places, Matrix<dim>::Identity());
  if constexpr (dim == 2) {
    for (std::size_t k = 0; k < turns.size(); ++k) {
      const double angle = u[(places + k) * 2] / settings.rotation_length;
      turns[k] = Eigen::Rotation2Dd(angle).toRotationMatrix();
    }
  } else {
    for (std::size_t b = 0; b < cells.line_blocks().size(); ++b) {
      const LineBlock<dim>& block = cells.line_blocks()[b];
      if (!block.beams()) continue;
      const auto own = cells.of_line_block(history, b);
      for (std::size_t k = 0; k < block.lines().size(); ++k) {
        const auto ends = settings.mesh.line(block.lines()[k]);
        for (std::size_t end = 0; end < 2; ++end) {
          const double* q = &own[k * block.history_width() + 4 * end];
          turns[settings.rotation_nodes[ends[end]] - places] =
              Eigen::Quaterniond(1 + q[0], q[1], q[2], q[3]).toRotationMatrix();
        }
      }
    }
  }
  return turns;
}

template <int dim>
void turn_on(const FemSettings<dim>& settings, std::span<const double> v, double time,
             std::vector<Matrix<dim>>& turns) {
  const auto places = static_cast<std::size_t>(settings.num_places());
  for (std::size_t k = 0; k < turns.size(); ++k) {
    const double* spin = v.data() + (places + k) * dim;
    const double scale = time / settings.rotation_length;
    if constexpr (dim == 2) {
      turns[k] = Eigen::Rotation2Dd(scale * spin[0]).toRotationMatrix() * turns[k];
    } else {
      const Vector<3> turn = scale * Vector<3>(spin[0], spin[1], spin[2]);
      const double angle = turn.norm();
      if (angle > 0) turns[k] = Eigen::AngleAxisd(angle, turn / angle) * turns[k];
    }
  }
}

template <int dim>
BeamSurfaces<dim>::BeamSurfaces(const FemSettings<dim>& settings) : settings_(settings) {
  for (const BeamSurfaceSettings& surface : settings.beam_surfaces) {
    const BeamOutline<dim> outline = beam_outline(settings, surface.groups, surface.where);
    InterfaceMesh mesh;
    mesh.name = surface.name;
    mesh.dim = dim;
    mesh.vertices_per_facet = dim == 2 ? 2 : 4;
    mesh.facets.assign(outline.facets.begin(), outline.facets.end());
    auto& vertices = vertices_.emplace_back();
    for (std::size_t k = 0; k < outline.nodes.size(); ++k) {
      const std::int32_t node = outline.nodes[k];
      vertices.push_back({node, settings.rotation_nodes[node], outline.offsets[k]});
      const Vector<dim> x = settings.mesh.nodes[node] + outline.offsets[k];
      mesh.coordinates.insert(mesh.coordinates.end(), x.data(), x.data() + dim);
    }
    meshes_.push_back(std::move(mesh));
    kinds_.push_back(ForceKind::end_of_step);
  }
}

template <int dim>
bool BeamSurfaces<dim>::has(const std::string& name) const {
  return std::ranges::any_of(meshes_, [&](const auto& mesh) { return mesh.name == name; });
}

template <int dim>
void BeamSurfaces<dim>::set_force_kind(const std::string& name, ForceKind kind) {
  for (std::size_t s = 0; s < meshes_.size(); ++s) {
    if (meshes_[s].name == name) kinds_[s] = kind;
  }
}

template <int dim>
void BeamSurfaces<dim>::add_forces(const InterfaceValues& received,
                                   std::span<const Matrix<dim>> turns,
                                   ExternalForces& forces) const {
  const std::size_t num_dofs = settings_.mesh.nodes.size() * dim;
  forces.end.resize(num_dofs, 0.0);
  forces.step.resize(num_dofs, 0.0);
  for (std::size_t s = 0; s < meshes_.size(); ++s) {
    const auto found = received.find(meshes_[s].name);
    require(found != received.end(), "received no forces of interface \"{}\"", meshes_[s].name);
    const auto& values = found->second;
    require(values.size() == vertices_[s].size() * dim,
            "interface \"{}\": received {} force values, expected {} vertices x {}",
            meshes_[s].name, values.size(), vertices_[s].size(), dim);
    auto& f = kinds_[s] == ForceKind::step_mean ? forces.step : forces.end;
    for (std::size_t k = 0; k < vertices_[s].size(); ++k) {
      const Vertex& vertex = vertices_[s][k];
      const Eigen::Map<const Vector<dim>> own(values.data() + k * dim);
      Eigen::Map<Vector<dim>>(f.data() + static_cast<std::size_t>(vertex.place) * dim) += own;
      const Vector<dim> arm = turn_of(vertex, turns) * vertex.offset;
      double* moment = f.data() + static_cast<std::size_t>(vertex.rotation) * dim;
      if constexpr (dim == 2) {
        moment[0] += (arm[0] * own[1] - arm[1] * own[0]) / settings_.rotation_length;
      } else {
        Eigen::Map<Vector<3>> about(moment);
        about += arm.cross(Vector<3>(own)) / settings_.rotation_length;
      }
    }
  }
}

template <int dim>
void BeamSurfaces<dim>::add_displacements(std::span<const double> u,
                                          std::span<const Matrix<dim>> turns,
                                          InterfaceValues& sent) const {
  for (std::size_t s = 0; s < meshes_.size(); ++s) {
    std::vector<double> values;
    for (const Vertex& vertex : vertices_[s]) {
      const Eigen::Map<const Vector<dim>> own(u.data() +
                                              static_cast<std::size_t>(vertex.place) * dim);
      const Vector<dim> moved = own + turn_of(vertex, turns) * vertex.offset - vertex.offset;
      values.insert(values.end(), moved.data(), moved.data() + dim);
    }
    sent[meshes_[s].name] = std::move(values);
  }
}

template class BeamSurfaces<2>;
template class BeamSurfaces<3>;
template void turn_on(const FemSettings<2>&, std::span<const double>, double,
                      std::vector<Matrix<2>>&);
template void turn_on(const FemSettings<3>&, std::span<const double>, double,
                      std::vector<Matrix<3>>&);
template std::vector<Matrix<2>> beam_turns(const FemSettings<2>&, const CellIntegrals<2>&,
                                           std::span<const double>, std::span<const double>);
template std::vector<Matrix<3>> beam_turns(const FemSettings<3>&, const CellIntegrals<3>&,
                                           std::span<const double>, std::span<const double>);

}  // namespace gabion::fem
