// SPDX-License-Identifier: BSD-3-Clause
#include "fem_solver/supports/boundary_conditions.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

#include "common/mechanics/elements/shape_functions.hpp"
#include "common/mechanics/ranks/text.hpp"

namespace gabion::fem {

namespace {

// Marks of degrees of freedom that no function of time prescribes.
constexpr int free_dof = -2, fixed_dof = -1;

}  // namespace

template <int dim>
std::int32_t node_at(const Mesh<dim>& mesh, const MeshRanks& ranks, const Vector<dim>& point,
                     const std::string& where) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  Vector<dim> low = Vector<dim>::Constant(infinity), high = -low;
  std::int32_t nearest = -1;
  double own_distance = infinity;
  for (std::int32_t i = 0; i < mesh.num_nodes_total(); ++i) {  // rotations follow their places
    const Vector<dim>& x = mesh.nodes[i];
    low = low.cwiseMin(x);
    high = high.cwiseMax(x);
    const double distance = (x - point).norm();
    if (distance < own_distance) {
      own_distance = distance;
      nearest = i;
    }
  }
  const SharedNodes& shared = ranks.shared();
  for (int d = 0; d < dim; ++d) {
    low[d] = -shared.largest(-low[d]);
    high[d] = shared.largest(high[d]);
  }
  const double distance = -shared.largest(-own_distance);
  const bool is_nearest = nearest >= 0 && own_distance == distance;
  const double allowed = 1e-6 * (high - low).norm();
  if (distance <= allowed) {
    const double own = is_nearest ? ranks.node_of_all(nearest) : infinity;
    return static_cast<std::int32_t>(-shared.largest(-own));
  }
  std::string place;
  if (is_nearest) {
    const Vector<dim>& x = mesh.nodes[nearest];
    place = fmt::format("{}", fmt::join(x.data(), x.data() + dim, ", "));
  }
  throw ConfigError(
      fmt::format("{}: no node at [{}]; the nearest is [{}], {:.3g} m away (allowed: {:.3g} m)",
                  where, fmt::join(point.data(), point.data() + dim, ", "),
                  shared.first_text(place), distance, allowed));
}

namespace {

/// Area of the parallelogram spanned by the columns of a dim x (dim - 1) Jacobian.
template <int dim>
double facet_measure(const Eigen::Matrix<double, dim, dim - 1>& jacobian) {
  return std::sqrt((jacobian.transpose() * jacobian).determinant());
}

}  // namespace

template <int dim>
std::vector<double> facet_weights(const Mesh<dim>& mesh, std::span<const std::int32_t> facets) {
  constexpr int facet_dim = dim - 1;
  const CellType type = facet_type(mesh.cell_type);
  const int n = num_nodes(type);
  std::vector<double> weights(mesh.nodes.size(), 0.0);
  AnyShapeValues<facet_dim> shape;
  const int degree = is_quadratic(type) ? 5 : 3;
  for (const auto& q : gauss_rule<facet_dim>(type, degree)) {
    shape_functions<facet_dim>(type, q.xi, shape);
    for (std::size_t f = 0; f + n <= facets.size(); f += n) {
      Eigen::Matrix<double, dim, facet_dim> jacobian =
          Eigen::Matrix<double, dim, facet_dim>::Zero();
      for (int a = 0; a < n; ++a) {
        jacobian += mesh.nodes[facets[f + a]] * shape.dN[a].transpose();
      }
      const double area = q.weight * facet_measure<dim>(jacobian);
      for (int a = 0; a < n; ++a) weights[facets[f + a]] += shape.N[a] * area;
    }
  }
  return weights;
}

template <int dim>
BoundaryConditions<dim>::BoundaryConditions(const FemSettings<dim>& settings) {
  std::vector<int> owner;
  together<ConfigError>(settings.ranks.comm(), [&] { owner = find_owners(settings); });
  for (const std::int32_t i : settings.embedded.nodes) {  // no unknowns
    for (int c = 0; c < dim; ++c) owner[static_cast<std::size_t>(i) * dim + c] = fixed_dof;
  }
  collect_constraints(owner);
  collect_loads(settings);
}

template <int dim>
void BoundaryConditions<dim>::add_constraint(std::vector<int>& owner, const Constraint& constraint,
                                             const MeshRanks& ranks, const std::string& where) {
  const auto& [node, component, function] = constraint;
  int& current = owner[static_cast<std::size_t>(node) * dim + component];
  if (current == free_dof || (current == fixed_dof && function == fixed_dof)) {
    current = function;
    return;
  }
  throw ConfigError(
      fmt::format("{}: component {} of node {} is already {} by another entry; allowed: one "
                  "condition a component",
                  where, component_names[component], ranks.node_of_all(node),
                  current == fixed_dof ? "fixed" : "prescribed"));
}

/// Find what prescribes each degree of freedom: a function of time, a support, or nothing.
template <int dim>
std::vector<int> BoundaryConditions<dim>::find_owners(const FemSettings<dim>& settings) {
  const MeshRanks& ranks = settings.ranks;
  std::vector<int> owner(settings.mesh.nodes.size() * dim, free_dof);
  for (const auto& support : settings.supports) {
    for (const auto node : ranks.group_nodes(settings.mesh, support.group, support.where)) {
      for (const int c : support.components)
        add_constraint(owner, {node, c, fixed_dof}, ranks, support.where);
      for (const int c : support.rotations) {
        const int own = dim == 2 ? 0 : c;
        add_constraint(owner, {settings.beam_nodes().of(node), own, fixed_dof}, ranks,
                       support.where);
      }
    }
  }
  for (const std::int32_t node : settings.rotation_nodes) {
    if (dim == 2 && node >= 0) add_constraint(owner, {node, 1, fixed_dof}, ranks, "");
  }
  for (const auto& prescribed : settings.prescribed) {
    const int function = static_cast<int>(functions_.size());
    functions_.push_back(prescribed.displacement);
    for (const auto node : ranks.group_nodes(settings.mesh, prescribed.group, prescribed.where)) {
      add_constraint(owner, {node, prescribed.component, function}, ranks, prescribed.where);
    }
  }
  return owner;
}

template <int dim>
void BoundaryConditions<dim>::collect_constraints(const std::vector<int>& owner) {
  const auto num_nodes = static_cast<std::int32_t>(owner.size() / dim);
  for (std::int32_t i = 0; i < num_nodes; ++i) {
    Matrix<dim> projector = Matrix<dim>::Identity();
    for (int c = 0; c < dim; ++c) {
      const int function = owner[static_cast<std::size_t>(i) * dim + c];
      if (function == free_dof) continue;
      projector(c, c) = 0;
      dofs_.push_back(i * dim + c);
      dof_functions_.push_back(function);
    }
    if (projector == Matrix<dim>::Identity()) continue;
    nodes_.push_back(i);
    projectors_.push_back(projector);
  }
}

namespace {

/// Held nodes that a load, mass or spring acts on; all of them share it.
template <int dim, class Settings>
std::vector<std::int32_t> nodes_of(const FemSettings<dim>& settings, const Settings& item) {
  const MeshRanks& ranks = settings.ranks;
  if (!item.point) return ranks.group_nodes(settings.mesh, item.group, item.where);
  const std::int32_t held = ranks.held_node(node_at(settings.mesh, ranks, *item.point, item.where));
  return held < 0 ? std::vector<std::int32_t>() : std::vector{held};
}

/// Call add(node, share) for the loaded nodes that this rank owns.
template <int dim, class Settings, class Add>
void share_out(const FemSettings<dim>& settings, const Settings& item, const Add& add) {
  const SharedNodes& shared = settings.ranks.shared();
  auto nodes = nodes_of(settings, item);
  std::erase_if(nodes, [&](std::int32_t node) { return !shared.owns(node); });
  const double share = 1 / shared.total(static_cast<double>(nodes.size()));
  for (const std::int32_t node : nodes) add(node, share);
}

}  // namespace

template <int dim>
NodalParts<dim> nodal_parts(const FemSettings<dim>& settings) {
  NodalParts<dim> parts;
  for (const auto& item : settings.point_masses) {
    share_out(settings, item,
              [&](std::int32_t node, double share) { parts.add_mass_at(node, share * item.mass); });
  }
  for (const auto& item : settings.springs) {
    share_out(settings, item, [&](std::int32_t node, double share) {
      parts.add_spring_at(node, share * item.stiffness);
    });
  }
  return parts;
}

template <int dim>
void add_dashpots(const FemSettings<dim>& settings, BlockMatrix<dim>& C) {
  for (const auto& item : settings.dashpots) {
    share_out(settings, item, [&](std::int32_t node, double share) {
      C.add_block(node, node, Matrix<dim>((share * item.damping).asDiagonal()));
    });
  }
}

namespace {

template <int dim>
std::vector<std::int32_t> rotations_of(const FemSettings<dim>& settings,
                                       const LoadSettings<dim>& load,
                                       std::span<const std::int32_t> nodes) {
  std::vector<std::int32_t> rotations;
  for (const auto node : nodes) {
    rotations.push_back(settings.beam_nodes().of(node));
    if (rotations.back() >= 0) continue;
    throw ConfigError(fmt::format(
        "{}: found a \"moment\" on node {}, which is of no beam, allowed: nodes of lines "
        "with \"law\" \"beam\"",
        load.where, settings.ranks.node_of_all(node)));
  }
  return rotations;
}

/// Part of a moment that acts on the unknowns of a rotation.
template <int dim>
Vector<dim> moment_share(const Vector<3>& moment) {
  if constexpr (dim == 2) {
    return {moment[2], 0};
  } else {
    return moment;
  }
}

}  // namespace

template <int dim>
void BoundaryConditions<dim>::collect_loads(const FemSettings<dim>& settings) {
  const Mesh<dim>& mesh = settings.mesh;
  const SharedNodes& shared = settings.ranks.shared();
  for (const auto& load : settings.loads) {
    const auto nodes = nodes_of(settings, load);
    const auto own = std::ranges::count_if(nodes, [&](auto node) { return shared.owns(node); });
    const Vector<dim> share = load.force / shared.total(static_cast<double>(own));
    loads_.push_back({.nodes = nodes,
                      .forces = std::vector<Vector<dim>>(nodes.size(), share),
                      .factor = load.factor});
    if (load.moment.isZero(0)) continue;
    loads_.push_back(
        {.nodes = rotations_of(settings, load, nodes),
         .forces = std::vector<Vector<dim>>(
             nodes.size(), moment_share<dim>(load.moment) /
                               (settings.rotation_length * shared.total(static_cast<double>(own)))),
         .factor = load.factor});
  }
  for (const auto& traction : settings.tractions) {
    auto weights = facet_weights(
        mesh, std::span<const std::int32_t>(mesh.facets(traction.group, traction.where)));
    shared.sum(weights, 1);
    Load load{.nodes = {}, .forces = {}, .factor = traction.factor};
    for (const auto node : settings.ranks.group_nodes(mesh, traction.group, traction.where)) {
      load.nodes.push_back(node);
      load.forces.push_back(weights[node] * traction.traction);
    }
    loads_.push_back(std::move(load));
  }
}

template <int dim>
std::vector<double> BoundaryConditions<dim>::displacements(double time) const {
  std::vector<double> result(dofs_.size(), 0.0);
  for (std::size_t i = 0; i < dofs_.size(); ++i) {
    if (dof_functions_[i] >= 0) result[i] = functions_[dof_functions_[i]].at(time);
  }
  return result;
}

template <int dim>
void BoundaryConditions<dim>::add_loads(double time, std::span<double> f) const {
  for (const auto& load : loads_) {
    const double factor = load.factor.at(time);
    for (std::size_t k = 0; k < load.nodes.size(); ++k) {
      for (int c = 0; c < dim; ++c) {
        f[static_cast<std::size_t>(load.nodes[k]) * dim + c] += factor * load.forces[k][c];
      }
    }
  }
}

template <int dim>
bool BoundaryConditions<dim>::constant_after(double time) const {
  for (const auto& f : functions_) {
    if (!f.constant_after(time)) return false;
  }
  for (const auto& load : loads_) {
    if (!load.factor.constant_after(time)) return false;
  }
  return true;
}

template std::int32_t node_at<2>(const Mesh<2>&, const MeshRanks&, const Vector<2>&,
                                 const std::string&);
template std::int32_t node_at<3>(const Mesh<3>&, const MeshRanks&, const Vector<3>&,
                                 const std::string&);
template std::vector<double> facet_weights<2>(const Mesh<2>&, std::span<const std::int32_t>);
template std::vector<double> facet_weights<3>(const Mesh<3>&, std::span<const std::int32_t>);
template NodalParts<2> nodal_parts(const FemSettings<2>&);
template NodalParts<3> nodal_parts(const FemSettings<3>&);
template void add_dashpots(const FemSettings<2>&, BlockMatrix<2>&);
template void add_dashpots(const FemSettings<3>&, BlockMatrix<3>&);
template class BoundaryConditions<2>;
template class BoundaryConditions<3>;

}  // namespace gabion::fem
