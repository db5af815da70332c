// SPDX-License-Identifier: BSD-3-Clause
#include "fem_solver/report/fem_probes.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <limits>
#include <optional>
#include <span>
#include <utility>

#include "common/base/require.hpp"
#include "common/mechanics/elements/shape_functions.hpp"
#include "fem_solver/report/failure_log.hpp"
#include "fem_solver/stress/bar_values.hpp"
#include "fem_solver/stress/cell_damage.hpp"
#include "fem_solver/stress/cell_failure.hpp"
#include "fem_solver/supports/boundary_conditions.hpp"

namespace gabion::fem {

namespace {

/// Reference coordinates of a point in a cell by Newton's method; none when the point lies outside.
template <int dim>
std::optional<AnyShapeValues<dim>> shape_at(const Mesh<dim>& mesh, std::int32_t c,
                                            const Vector<dim>& point) {
  const bool simplex = is_simplex(mesh.cell_type);
  Vector<dim> xi = Vector<dim>::Constant(simplex ? 1.0 / (dim + 1) : 0.0);
  AnyShapeValues<dim> shape;
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

/// Area of a facet, in 2D its length [m^(dim - 1)].
template <int dim>
double facet_area(std::span<const Vector<dim>> corners) {
  if constexpr (dim == 2) {
    return (corners[1] - corners[0]).norm();
  } else {
    double area = 0;
    for (std::size_t k = 2; k < corners.size(); ++k) {
      area += 0.5 * (corners[k - 1] - corners[0]).cross(corners[k] - corners[0]).norm();
    }
    return area;
  }
}

/// Mean place of a group's nodes, of all ranks, before loading.
template <int dim>
Vector<dim> centre_of_nodes(const FemSettings<dim>& settings, const SupportSettings& support) {
  std::vector<double> sums(dim + 1, 0.0);
  const MeshRanks& ranks = settings.ranks;
  for (const auto i : ranks.group_nodes(settings.mesh, support.group, support.where)) {
    if (!ranks.shared().owns(i)) continue;
    for (int c = 0; c < dim; ++c) sums[c] += settings.mesh.nodes[i][c];
    sums[dim] += 1;
  }
  ranks.shared().total(sums);
  return Eigen::Map<const Vector<dim>>(sums.data()) / sums[dim];
}

/// Centre of area of a group's facets, of all ranks, before loading; without facets of its nodes.
template <int dim>
Vector<dim> centre_of_facets(const FemSettings<dim>& settings, const SupportSettings& support) {
  const Mesh<dim>& mesh = settings.mesh;
  const std::size_t n = num_nodes(facet_type(mesh.cell_type));
  std::vector<double> sums(dim + 1, 0.0);
  if (!mesh.facet_groups.contains(support.group)) return centre_of_nodes(settings, support);
  const auto& facets = mesh.facets(support.group, support.where);
  if (is_quadratic(mesh.cell_type)) {
    const std::vector<double> weights = facet_weights(mesh, facets);
    for (std::size_t i = 0; i < weights.size(); ++i) {
      for (int c = 0; c < dim; ++c) sums[c] += weights[i] * mesh.nodes[i][c];
      sums[dim] += weights[i];
    }
  }
  for (std::size_t f = 0; f < facets.size() && !is_quadratic(mesh.cell_type); f += n) {
    std::vector<Vector<dim>> corners;
    Vector<dim> middle = Vector<dim>::Zero();
    for (std::size_t a = 0; a < n; ++a) {
      corners.push_back(mesh.nodes[facets[f + a]]);
      middle += corners.back() / static_cast<double>(n);
    }
    const double area = facet_area<dim>(corners);
    for (int c = 0; c < dim; ++c) sums[c] += area * middle[c];
    sums[dim] += area;
  }
  settings.ranks.shared().total(sums);
  return Eigen::Map<const Vector<dim>>(sums.data()) / sums[dim];
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
    return fmt::format(
        "{}: found [{}], allowed: a point inside the cells; of lines and membranes a node",
        probe.where, fmt::join(probe.point.data(), probe.point.data() + dim, ", "));
  });
  const std::int32_t c = ranks.held_cell(cell);
  if (c < 0) return {};
  const auto nodes = mesh.cell(c);
  const auto shape = shape_at<dim>(mesh, c, probe.point);
  return {{nodes.begin(), nodes.end()}, {shape->N, shape->N + nodes.size()}};
}

template <int dim>
FemProbes<dim>::FemProbes(const FemSettings<dim>& settings)
    : ranks_(settings.ranks), mesh_(settings.mesh), settings_(settings) {
  for (const auto& probe : settings.probes) {
    points_.push_back(locate(settings, probe));
    for (int c = 0; c < dim; ++c) {
      names_.push_back(fmt::format("{}.u{}", probe.name, component_names[c]));
    }
  }
  names_.insert(names_.end(), {"kinetic_energy", "elastic_energy", "external_work"});
  for (int c = 0; c < dim; ++c) names_.push_back(fmt::format("momentum_{}", component_names[c]));
  for (const auto& support : settings.supports) {
    if (support.report_reaction || support.report_moment) add_reaction(settings, support);
  }
  name_yielding(settings);
  for (const LineMaterial& material : settings.line_materials) {
    names_.insert(names_.end(), {"axial_max_" + material.group, "axial_min_" + material.group});
    if (material.hardening && !material.beam) {
      names_.insert(names_.end(), {"stress_max_" + material.group, "stress_min_" + material.group});
    }
    if (material.beam) {
      names_.insert(names_.end(), {"shear_max_" + material.group, "bending_max_" + material.group,
                                   "torsion_max_" + material.group});
    }
    if (!material.brake) continue;
    brakes_ = true;
    names_.push_back("brake_run_" + material.group);
  }
  if (brakes_) names_.push_back("brake_work");
  if (is_damped(settings)) names_.push_back("damping_work");
  bool cracks = false;
  for (const auto& material : settings.materials) {
    if (!std::holds_alternative<Concrete<dim>>(material.law)) continue;
    if (!cracks) names_.insert(names_.end(), {"damage_work", "crack_width"});
    cracks = true;
    if (!material.group.empty()) names_.push_back("crack_width_" + material.group);
  }
  if (may_fail(settings)) names_.insert(names_.end(), {"failed_cells", "failed_energy"});
}

/// Names of what add_plastic() adds.
template <int dim>
void FemProbes<dim>::name_yielding(const FemSettings<dim>& settings) {
  std::vector<std::string> groups;
  for (const auto& material : settings.materials) {
    if (!std::holds_alternative<VonMises<dim>>(material.law)) continue;
    yields_ = true;
    if (!material.group.empty()) groups.push_back(material.group);
  }
  for (const LineMaterial& material : settings.line_materials) {
    if (!material.hardening) continue;
    yields_ = true;
    groups.push_back(material.group);
  }
  if (yields_) names_.insert(names_.end(), {"plastic_work", "plastic_strain"});
  for (const std::string& group : groups) names_.push_back("plastic_strain_" + group);
}

template <int dim>
void FemProbes<dim>::add_reaction(const FemSettings<dim>& settings,
                                  const SupportSettings& support) {
  auto nodes = ranks_.group_nodes(settings.mesh, support.group, support.where);
  std::erase_if(nodes, [&](std::int32_t i) { return !ranks_.shared().owns(i); });
  std::vector<std::int32_t> rotations;
  for (const std::int32_t i : nodes) {
    if (settings.beam_nodes().of(i) >= 0) rotations.push_back(settings.beam_nodes().of(i));
  }
  Reaction reaction{.nodes = std::move(nodes),
                    .rotations = std::move(rotations),
                    .force = support.report_reaction,
                    .moment = support.report_moment};
  for (int c = 0; c < dim && reaction.force; ++c) {
    names_.push_back(fmt::format("reaction_{}_{}", support.group, component_names[c]));
  }
  if (reaction.moment) {
    reaction.centre = centre_of_facets(settings, support);
    for (int c = dim == 2 ? 2 : 0; c < 3; ++c) {
      names_.push_back(fmt::format("moment_{}_{}", support.group, component_names[c]));
    }
  }
  reactions_.push_back(std::move(reaction));
}

/// Sums over the nodes of this rank.
template <int dim>
void FemProbes<dim>::add_values(const Reaction& reaction, const StructureState& state,
                                std::vector<double>& values) const {
  Vector<dim> force = Vector<dim>::Zero();
  Vector<3> moment = Vector<3>::Zero();
  for (const auto node : reaction.nodes) {
    const std::size_t first = static_cast<std::size_t>(node) * dim;
    const Eigen::Map<const Vector<dim>> r(state.reactions.data() + first);
    force += r;
    if (!reaction.moment) continue;
    const Eigen::Map<const Vector<dim>> u(state.motion.u.data() + first);
    Vector<3> arm = Vector<3>::Zero(), r_3 = Vector<3>::Zero();
    arm.template head<dim>() = mesh_.nodes[node] + u - reaction.centre;
    r_3.template head<dim>() = r;
    moment += arm.cross(r_3);
  }
  for (const auto node : reaction.rotations) {
    moment += moment_of<dim>(state.reactions, node, settings_.rotation_length);
  }
  if (reaction.force) values.insert(values.end(), force.data(), force.data() + dim);
  if (!reaction.moment) return;
  values.insert(values.end(), moment.data() + (dim == 2 ? 2 : 0), moment.data() + 3);
}

/// Work, the largest strain of all cells, then of each group.
template <int dim>
void FemProbes<dim>::add_plastic(const StructureState& state, const CellIntegrals<dim>& cells,
                                 std::vector<double>& values) const {
  if (!yields_) return;
  std::vector<double> of_groups;
  double largest = 0;
  for (std::size_t b = 0; b < cells.blocks().size(); ++b) {
    const CellBlock<dim>& block = cells.blocks()[b];
    if (!block.yields()) continue;
    const double own = block.largest_plastic_strain(cells.of_block(*state.history, b));
    const double of_block = ranks_.shared().largest(own);
    largest = std::max(largest, of_block);
    if (!block.material().group.empty()) of_groups.push_back(of_block);
  }
  for (std::size_t b = 0; b < cells.line_blocks().size(); ++b) {
    const LineBlock<dim>& block = cells.line_blocks()[b];
    if (!block.yields()) continue;
    double own = 0;
    for (const double strain : block.plastic_strains(cells.of_line_block(*state.history, b))) {
      own = std::max(own, strain);
    }
    of_groups.push_back(ranks_.shared().largest(own));
    largest = std::max(largest, of_groups.back());
  }
  values.insert(values.end(), {state.plastic_work, largest});
  values.insert(values.end(), of_groups.begin(), of_groups.end());
}

/// Energy, the widest crack of all cells, then of each group.
template <int dim>
void FemProbes<dim>::add_damage(const StructureState& state, const CellIntegrals<dim>& cells,
                                std::vector<double>& values) const {
  if (!cells.cracks()) return;
  std::vector<double> of_groups;
  double widest = 0;
  for (std::size_t b = 0; b < cells.blocks().size(); ++b) {
    const CellBlock<dim>& block = cells.blocks()[b];
    if (!block.cracks()) continue;
    double own = 0;
    for (const CellDamage& cell : block_damage(block, cells.of_block(*state.history, b))) {
      own = std::max(own, cell.crack_width);
    }
    const double of_block = ranks_.shared().largest(own);
    widest = std::max(widest, of_block);
    if (!block.material().group.empty()) of_groups.push_back(of_block);
  }
  values.insert(values.end(), {state.damage_work, widest});
  values.insert(values.end(), of_groups.begin(), of_groups.end());
}

/// Append the values of each group of lines, over all ranks.
template <int dim>
void FemProbes<dim>::add_lines(const StructureState& state, const CellIntegrals<dim>& cells,
                               std::vector<double>& values) const {
  constexpr double none = -std::numeric_limits<double>::infinity();
  const std::span<const double> history =
      state.history ? std::span<const double>(*state.history) : std::span<const double>();
  for (std::size_t b = 0; b < cells.line_blocks().size(); ++b) {
    const LineBlock<dim>& block = cells.line_blocks()[b];
    const auto own = history_before_failure(block, cells.of_line_block(history, b), state.time);
    double largest = none, minus_least = none, run = none;
    for (const double force : block.forces(state.motion.u, own)) {
      largest = std::max(largest, force);
      minus_least = std::max(minus_least, -force);
    }
    for (std::size_t k = 0; block.material().brake && k < own.size(); k += block.history_width()) {
      run = std::max(run, own[k]);
    }
    values.push_back(ranks_.shared().largest(largest));
    values.push_back(-ranks_.shared().largest(minus_least));
    if (block.beams()) {
      for (const double size : largest_resultants(*block.beams(), state.motion.u, own)) {
        values.push_back(ranks_.shared().largest(size));
      }
    }
    if (block.yields() && !block.beams()) {
      const double area = block.material().area;
      values.insert(values.end(), {values[values.size() - 2] / area, values.back() / area});
    }
    if (block.material().brake) values.push_back(ranks_.shared().largest(run));
  }
  if (brakes_) values.push_back(state.brake_work);
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
  const auto num_places = static_cast<std::size_t>(settings_.num_places());
  for (std::size_t i = 0; i < momentum.size(); ++i) {
    if (!ranks_.shared().owns(static_cast<std::int32_t>(i / dim))) continue;
    if (i < num_places * dim) total[i % dim] += momentum[i];
    kinetic_energy += 0.5 * momentum[i] * state.motion.v[i];
  }
  const std::size_t energies = result.size();
  result.insert(result.end(), {kinetic_energy, 0.0, 0.0});
  add_vector(total);
  for (const Reaction& reaction : reactions_) add_values(reaction, state, result);
  ranks_.shared().total(result);
  result[energies + 1] = state.elastic_energy;
  result[energies + 2] = state.external_work;
  add_plastic(state, equilibrium.cells(), result);
  add_lines(state, equilibrium.cells(), result);
  if (equilibrium.damped()) result.push_back(state.damping_work);
  add_damage(state, equilibrium.cells(), result);
  if (equilibrium.may_fail()) {
    const auto own = static_cast<double>(count_failed(equilibrium.cells(), *state.history));
    result.insert(result.end(), {ranks_.shared().total(own), state.failed_energy});
  }
  return result;
}

template class FemProbes<2>;
template class FemProbes<3>;

}  // namespace gabion::fem
