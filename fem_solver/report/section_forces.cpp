// SPDX-License-Identifier: BSD-3-Clause
#include "fem_solver/report/section_forces.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>

#include "common/base/require.hpp"

namespace gabion::fem {

namespace {

/// Histories of some cells of a block, width values each.
std::vector<double> history_of(std::span<const double> of_block,
                               std::span<const std::size_t> places, std::size_t width) {
  std::vector<double> history;
  for (const std::size_t k : places) {
    const auto own = of_block.subspan(k * width, width);
    history.insert(history.end(), own.begin(), own.end());
  }
  return history;
}

/// Nodes that a cell, line or sheet acts on.
template <int dim>
std::vector<std::int32_t> nodes_of(const FemSettings<dim>& settings, std::int32_t element) {
  const Mesh<dim>& mesh = settings.mesh;
  const auto nodes = mesh.element(element);
  if (element >= mesh.num_cells() && element < mesh.num_cells() + mesh.num_lines()) {
    return settings.embedded.line_nodes(mesh, element - mesh.num_cells());
  }
  return {nodes.begin(), nodes.end()};
}

/// Distance of the centre of an element from a plane, over its radius, below which it lies on the
/// plane, and counts as in front: whatever way a scene is turned.
constexpr double on_the_plane = 1e-9;

}  // namespace

template <int dim>
SectionForces<dim>::SectionForces(const FemSettings<dim>& settings,
                                  const SectionSettings<dim>& section,
                                  const CellIntegrals<dim>& cells)
    : mesh_(settings.mesh),
      ranks_(settings.ranks),
      section_(section),
      beam_nodes_(settings.beam_nodes()) {
  const SharedNodes& shared = ranks_.shared();
  std::vector<double> sides(mesh_.nodes.size() * 2, 0.0);  // elements behind, in front
  for (std::int32_t e = 0; e < mesh_.num_elements(); ++e) {
    const std::size_t side = is_behind(mesh_.element(e)) ? 0 : 1;
    for (const std::int32_t i : nodes_of(settings, e))
      sides[static_cast<std::size_t>(i) * 2 + side] += 1;
  }
  count_links(cells, sides);
  shared.sum(sides, 2);
  double own = 0;
  cut_.resize(mesh_.nodes.size());
  for (std::size_t i = 0; i < cut_.size(); ++i) {
    cut_[i] = sides[2 * i] > 0 && sides[2 * i + 1] > 0;
    if (cut_[i] && shared.owns(static_cast<std::int32_t>(i))) own += 1;
  }
  num_cut_ = shared.total(own);
  require<ConfigError>(
      num_cut_ > 0,
      "{}: found a plane that does not cut the structure, of section \"{}\", allowed: one with "
      "cells or lines on both sides that share nodes",
      section_.where, section_.name);
  find_parts(settings, cells);
}

/// Assign links to the part of their beam.
template <int dim>
void SectionForces<dim>::count_links(const CellIntegrals<dim>& cells, std::vector<double>& sides) {
  std::vector<RigidLink<dim>> behind;
  const auto links = cells.links().links();
  for (std::size_t l = 0; l < links.size(); ++l) {
    const std::size_t side = is_behind(mesh_.line(links[l].line)) ? 0 : 1;
    sides[static_cast<std::size_t>(links[l].place) * 2 + side] += 1;
    for (const auto& arm : links[l].arms) sides[static_cast<std::size_t>(arm.node) * 2 + side] += 1;
    if (side == 1) continue;
    behind.push_back(links[l]);
    whose_.push_back(l);
  }
  links_ = RigidLinks<dim>(std::move(behind), beam_nodes_.length);
}

template <int dim>
bool SectionForces<dim>::is_behind(std::span<const std::int32_t> nodes) const {
  Vector<dim> centre = Vector<dim>::Zero();
  for (const std::int32_t i : nodes) centre += mesh_.nodes[i] / static_cast<double>(nodes.size());
  const double radius = (mesh_.nodes[nodes.front()] - centre).norm();
  return (centre - section_.point).dot(section_.normal) < -on_the_plane * radius;
}

template <int dim>
bool SectionForces<dim>::is_cut(const FemSettings<dim>& settings, std::int32_t element) const {
  return is_behind(mesh_.element(element)) &&
         std::ranges::any_of(nodes_of(settings, element),
                             [this](std::int32_t i) { return cut_[i] != 0; });
}

/// The cells and lines behind the plane that have nodes of the cut, block by block.
template <int dim>
void SectionForces<dim>::find_parts(const FemSettings<dim>& settings,
                                    const CellIntegrals<dim>& cells) {
  for (std::size_t b = 0; b < cells.blocks().size(); ++b) {
    const CellBlock<dim>& block = cells.blocks()[b];
    std::vector<std::int32_t> own;
    std::vector<std::size_t> places;
    for (std::size_t k = 0; k < block.cells().size(); ++k) {
      if (!is_cut(settings, block.cells()[k])) continue;
      own.push_back(block.cells()[k]);
      places.push_back(k);
    }
    if (own.empty()) continue;
    cell_parts_.push_back(
        {CellBlock<dim>(mesh_, block.material(), std::move(own), ranks_), b, std::move(places)});
  }
  for (std::size_t b = 0; b < cells.line_blocks().size(); ++b) {
    const LineBlock<dim>& block = cells.line_blocks()[b];
    std::vector<std::int32_t> own;
    std::vector<std::size_t> places;
    for (std::size_t k = 0; k < block.lines().size(); ++k) {
      if (!is_cut(settings, mesh_.num_cells() + block.lines()[k])) continue;
      own.push_back(block.lines()[k]);
      places.push_back(k);
    }
    if (own.empty()) continue;
    line_parts_.push_back(
        {LineBlock<dim>(mesh_, block.material(), std::move(own), settings.lumped_mass,
                        {{}, beam_nodes_, &settings.embedded}),
         b, std::move(places)});
  }
  find_membrane_parts(settings, cells);
}

template <int dim>
void SectionForces<dim>::find_membrane_parts(const FemSettings<dim>& settings,
                                             const CellIntegrals<dim>& cells) {
  if constexpr (dim == 3) {
    for (const MembraneBlock& block : cells.membranes().blocks()) {
      std::vector<std::int32_t> own;
      for (const std::int32_t s : block.sheets()) {
        if (is_cut(settings, mesh_.num_cells() + mesh_.num_lines() + s)) own.push_back(s);
      }
      membrane_parts_.emplace_back(mesh_, block.material(), std::move(own), block.lumped_mass());
    }
  }
}

template <int dim>
std::vector<std::string> SectionForces<dim>::names() const {
  std::vector<std::string> names = {section_.name + ".N"};
  for (int c = 0; c < dim; ++c) {
    names.push_back(fmt::format("{}.V_{}", section_.name, component_names[c]));
  }
  for (int c = dim == 2 ? 2 : 0; c < 3; ++c) {
    names.push_back(fmt::format("{}.M_{}", section_.name, component_names[c]));
  }
  return names;
}

/// Nodal forces of the elements behind that have nodes of the cut, num_nodes x dim.
template <int dim>
std::vector<double> SectionForces<dim>::forces_behind(const StructureState& state,
                                                      const CellIntegrals<dim>& cells) const {
  const std::span<const double> all =
      state.history ? std::span<const double>(*state.history) : std::span<const double>();
  std::vector<double> f(mesh_.nodes.size() * dim, 0.0);
  const auto add = [&](const auto& part, std::span<const double> of_block) {
    const std::vector<double> accepted =
        history_of(of_block, part.places, part.block.history_width());
    std::vector<double> trial = accepted;
    part.block.add_internal(state.motion.u, f, nullptr, {.accepted = accepted, .trial = trial});
  };
  for (const auto& part : cell_parts_) add(part, cells.of_block(all, part.of_block));
  for (const auto& part : line_parts_) add(part, cells.of_line_block(all, part.of_block));
  if constexpr (dim == 3) {
    for (const auto& part : membrane_parts_) part.add_internal(state.motion.u, f, nullptr);
  }
  if (links_.num_arms() > 0) {
    const auto histories = cells.link_histories(all);
    std::vector<std::span<const double>> own;
    for (const std::size_t l : whose_) own.push_back(histories[l]);
    links_.add_internal(state.motion.u, f, nullptr, 0, own);
  }
  return f;
}

template <int dim>
std::vector<double> SectionForces<dim>::values(const StructureState& state,
                                               const CellIntegrals<dim>& cells) const {
  const std::vector<double> f = forces_behind(state, cells);
  std::vector<double> sums(6 + dim, 0.0);  // force, moment about the point at rest, displacement
  Eigen::Map<Vector<3>> force(sums.data()), moment(sums.data() + 3);
  for (std::size_t i = 0; i < cut_.size(); ++i) {
    if (!cut_[i]) continue;
    const Eigen::Map<const Vector<dim>> u(state.motion.u.data() + i * dim);
    Vector<3> own = Vector<3>::Zero(), arm = Vector<3>::Zero();
    own.template head<dim>() = Eigen::Map<const Vector<dim>>(f.data() + i * dim);
    arm.template head<dim>() = mesh_.nodes[i] + u - section_.point;
    force += own;
    moment += arm.cross(own);
    if (const auto turn = beam_nodes_.of(static_cast<std::int32_t>(i)); turn >= 0) {
      moment += moment_of<dim>(f, turn, beam_nodes_.length);
    }
    if (!ranks_.shared().owns(static_cast<std::int32_t>(i))) continue;
    for (int c = 0; c < dim; ++c) sums[6 + c] += u[c] / num_cut_;
  }
  ranks_.shared().total(sums);
  Vector<3> moved = Vector<3>::Zero(), normal = Vector<3>::Zero();
  for (int c = 0; c < dim; ++c) moved[c] = sums[6 + c];
  normal.template head<dim>() = section_.normal;
  const double along = force.dot(normal);
  const Vector<3> across = force - along * normal;
  const Vector<3> about = moment - moved.cross(force);
  std::vector<double> result = {along};
  result.insert(result.end(), across.data(), across.data() + dim);
  result.insert(result.end(), about.data() + (dim == 2 ? 2 : 0), about.data() + 3);
  return result;
}

template class SectionForces<2>;
template class SectionForces<3>;

}  // namespace gabion::fem
