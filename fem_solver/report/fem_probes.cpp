// SPDX-License-Identifier: BSD-3-Clause
#include "fem_solver/report/fem_probes.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/LU>
#include <limits>
#include <optional>
#include <utility>

#include "common/base/require.hpp"
#include "common/mechanics/elements/shape_functions.hpp"

namespace gabion::fem {

namespace {

/// Reference coordinates of a point in a cell by Newton's method; none when the point lies outside.
template <int dim>
std::optional<ShapeValues<dim>> shape_at(const Mesh<dim>& mesh, std::int32_t c,
                                         const Vector<dim>& point) {
  const bool simplex = mesh.nodes_per_cell() == dim + 1;
  Vector<dim> xi = Vector<dim>::Constant(simplex ? 1.0 / (dim + 1) : 0.0);
  ShapeValues<dim> shape;
  for (int iteration = 0; iteration < 20; ++iteration) {
    shape_functions<dim>(mesh.cell_type, xi, shape);
    Vector<dim> x = Vector<dim>::Zero();
    Matrix<dim> jacobian = Matrix<dim>::Zero();
    for (int a = 0; a < mesh.nodes_per_cell(); ++a) {
      const Vector<dim>& node = mesh.nodes[mesh.cell(c)[a]];
      x += shape.N[a] * node;
      jacobian += node * shape.dN[a].transpose();
    }
    const Vector<dim> step = jacobian.inverse() * (point - x);
    if (step.norm() < 1e-12) {
      const double slack = 1e-9;
      const bool inside = simplex ? xi.minCoeff() >= -slack && xi.sum() <= 1 + slack
                                  : xi.cwiseAbs().maxCoeff() <= 1 + slack;
      return inside ? std::optional(shape) : std::nullopt;
    }
    xi += step;
    if (!(xi.norm() < 100)) return std::nullopt;
  }
  return std::nullopt;
}

/// The first cell of all ranks that holds a point, by its number in the whole; -1: none.
template <int dim>
std::int32_t first_cell_at(const FemSettings<dim>& settings, const Vector<dim>& point) {
  constexpr double none = std::numeric_limits<double>::infinity();
  double own = none;
  for (std::int32_t c = 0; c < settings.mesh.num_cells() && own == none; ++c) {
    if (shape_at<dim>(settings.mesh, c, point)) own = settings.ranks.cell_of_all(c);
  }
  const double first = -settings.ranks.shared().largest(-own);
  return first == none ? -1 : static_cast<std::int32_t>(first);
}

template <int dim>
std::optional<std::int32_t> node_of_probe(const FemSettings<dim>& settings,
                                          const ProbeSettings<dim>& probe) {
  try {
    return node_at(settings.mesh, settings.ranks, probe.point, probe.where);
  } catch (const ConfigError&) {
    return std::nullopt;
  }
}

}  // namespace

template <int dim>
typename FemProbes<dim>::Point FemProbes<dim>::locate(const FemSettings<dim>& settings,
                                                      const ProbeSettings<dim>& probe) {
  const Mesh<dim>& mesh = settings.mesh;
  const MeshRanks& ranks = settings.ranks;
  if (const auto node = node_of_probe(settings, probe)) {
    const std::int32_t held = ranks.held_node(*node);
    return held >= 0 && ranks.shared().owns(held) ? Point{{held}, {1.0}} : Point();
  }
  const std::int32_t cell = first_cell_at(settings, probe.point);
  require<ConfigError>(cell >= 0, [&] {
    return fmt::format("{}: found [{}], allowed: a point inside the mesh", probe.where,
                       fmt::join(probe.point.data(), probe.point.data() + dim, ", "));
  });
  const std::int32_t c = ranks.held_cell(cell);
  if (c < 0) return {};
  const auto nodes = mesh.cell(c);
  const auto shape = shape_at<dim>(mesh, c, probe.point);
  return {{nodes.begin(), nodes.end()}, {shape->N, shape->N + nodes.size()}};
}

template <int dim>
FemProbes<dim>::FemProbes(const FemSettings<dim>& settings) : ranks_(settings.ranks) {
  for (const auto& probe : settings.probes) {
    points_.push_back(locate(settings, probe));
    for (int c = 0; c < dim; ++c) {
      names_.push_back(fmt::format("{}.u{}", probe.name, component_names[c]));
    }
  }
  names_.insert(names_.end(), {"kinetic_energy", "elastic_energy", "external_work"});
  for (int c = 0; c < dim; ++c) names_.push_back(fmt::format("momentum_{}", component_names[c]));
  for (const auto& support : settings.supports) {
    if (!support.report_reaction) continue;
    auto nodes = ranks_.group_nodes(settings.mesh, support.group, support.where);
    std::erase_if(nodes, [&](std::int32_t i) { return !ranks_.shared().owns(i); });
    reaction_nodes_.push_back(std::move(nodes));
    for (int c = 0; c < dim; ++c) {
      names_.push_back(fmt::format("reaction_{}_{}", support.group, component_names[c]));
    }
  }
}

template <int dim>
std::vector<double> FemProbes<dim>::values(const StructureState& state,
                                           const Equilibrium<dim>& equilibrium) const {
  std::vector<double> result;
  const auto add_vector = [&](const Vector<dim>& x) {
    result.insert(result.end(), x.data(), x.data() + dim);
  };
  const auto at = [](const std::vector<double>& field, std::size_t node) {
    return Eigen::Map<const Vector<dim>>(field.data() + node * dim);
  };
  for (const auto& point : points_) {
    Vector<dim> u = Vector<dim>::Zero();
    for (std::size_t k = 0; k < point.nodes.size(); ++k) {
      u += point.weights[k] * at(state.motion.u, point.nodes[k]);
    }
    add_vector(u);
  }
  const std::vector<double> momentum = equilibrium.mass_times(state.motion.v);
  Vector<dim> total = Vector<dim>::Zero();
  double kinetic_energy = 0;
  for (std::size_t i = 0; i < momentum.size(); ++i) {
    if (!ranks_.shared().owns(static_cast<std::int32_t>(i / dim))) continue;
    total[i % dim] += momentum[i];
    kinetic_energy += 0.5 * momentum[i] * state.motion.v[i];
  }
  const std::size_t energies = result.size();
  result.insert(result.end(), {kinetic_energy, 0.0, 0.0});
  add_vector(total);
  for (const auto& nodes : reaction_nodes_) {
    Vector<dim> reaction = Vector<dim>::Zero();
    for (const auto node : nodes) reaction += at(state.reactions, node);
    add_vector(reaction);
  }
  ranks_.shared().total(result);
  result[energies + 1] = state.elastic_energy;
  result[energies + 2] = state.external_work;
  return result;
}

template class FemProbes<2>;
template class FemProbes<3>;

}  // namespace gabion::fem
