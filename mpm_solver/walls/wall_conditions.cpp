// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/walls/wall_conditions.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>

namespace gabion::mpm {

namespace {

// Pieces of walls whose normals differ by less than this (sine of the angle) have that of the
// first.
constexpr double same_direction = 1e-6;

// Motions of walls that share a node agree up to this share of the larger one.
constexpr double same_motion = 1e-9;

double degrees(double radians) {
  return radians * 180 / std::numbers::pi;
}

double radians(double degrees) {
  return degrees * std::numbers::pi / 180;
}

// Times at which a motion may change its velocity [s], ascending; the last one may be later than
// all of them.
std::vector<double> corner_times(const std::vector<WallSettings>& walls, double start, double end) {
  std::set<double> times = {start};
  for (const WallSettings& wall : walls) {
    for (const auto& row : wall.motion.table) {
      if (row[0] > start && row[0] < end) times.insert(row[0]);
    }
  }
  times.insert(std::isfinite(end) ? end : *times.rbegin() + 1);
  return {times.begin(), times.end()};
}

}  // namespace

template <int dim>
WallConditions<dim>::WallConditions(const BackgroundGrid<dim>& grid,
                                    const std::vector<WallSettings>& walls)
    : walls_(walls), steps_(walls.size(), Vector<dim>::Zero()) {
  std::set<std::int32_t> held;
  for (const WallSettings& wall : walls_) {
    const auto nodes = find_group_nodes(grid.facet_groups, wall.group, wall.where);
    held.insert(nodes.begin(), nodes.end());
  }
  for (const std::int32_t i : held) {
    nodes_.emplace_back();
    nodes_.back().grid_node = i;
  }
  add_fixed_walls(grid);
  add_slip_walls(grid);
  for (Node& node : nodes_) set_shares(node);
  find_held_normal(grid.num_nodes_total());
}

template <int dim>
void WallConditions<dim>::find_held_normal(std::int32_t num_grid_nodes) {
  if (nodes_.size() != static_cast<std::size_t>(num_grid_nodes)) return;
  const auto single = std::find_if(nodes_.begin(), nodes_.end(),
                                   [](const Node& node) { return node.num_holds == 1; });
  if (single == nodes_.end()) return;
  const Vector<dim>& n = single->holds[0].n;
  static const double flush = std::sin(radians(flush_angle));
  const bool everywhere = std::all_of(
      nodes_.begin(), nodes_.end(), [&](const Node& node) { return (node.Q * n).norm() <= flush; });
  if (everywhere) held_normal_ = n;
}

template <int dim>
void WallConditions<dim>::add_fixed_walls(const BackgroundGrid<dim>& grid) {
  const auto num_walls = static_cast<std::int32_t>(walls_.size());
  for (std::int32_t w = 0; w < num_walls; ++w) {
    if (!walls_[w].fixed) continue;
    for (const std::int32_t i :
         find_group_nodes(grid.facet_groups, walls_[w].group, walls_[w].where)) {
      for (int d = 0; d < dim; ++d) add(index_of(i), {w, Vector<dim>::Unit(d)});
    }
  }
}

template <int dim>
void WallConditions<dim>::add_slip_walls(const BackgroundGrid<dim>& grid) {
  std::vector<SlipPiece> pieces;
  const auto num_walls = static_cast<std::int32_t>(walls_.size());
  for (std::int32_t w = 0; w < num_walls; ++w) {
    if (walls_[w].fixed) continue;
    const auto& facets = find_facets(grid.facet_groups, walls_[w].group, walls_[w].where);
    for (const WallPiece<dim>& piece : smooth_pieces(grid, std::span(facets))) {
      pieces.push_back({index_of(piece.grid_node), w, piece.n, piece.area});
    }
  }
  std::stable_sort(pieces.begin(), pieces.end(),
                   [](const SlipPiece& a, const SlipPiece& b) { return a.node < b.node; });
  for (std::size_t first = 0; first < pieces.size();) {
    std::size_t last = first;
    while (last < pieces.size() && pieces[last].node == pieces[first].node) ++last;
    add_pieces(grid, std::span(pieces).subspan(first, last - first));
    first = last;
  }
}

// Add the pieces: flush ones become one, whose normal all of them get, and each direction is held
// once.
template <int dim>
void WallConditions<dim>::add_pieces(const BackgroundGrid<dim>& grid,
                                     std::span<SlipPiece> at_node) {
  static const double flush = std::cos(radians(flush_angle));
  const std::size_t node = at_node.front().node;
  const bool is_free = nodes_[node].num_holds == 0;
  std::vector<std::size_t> first_of(at_node.size());
  for (std::size_t k = 0; k < at_node.size(); ++k) {
    SlipPiece& piece = at_node[k];
    first_of[k] = k;
    for (std::size_t j = 0; j < k && first_of[k] == k; ++j) {
      if (first_of[j] != j) continue;
      SlipPiece& first = at_node[j];
      const double cosine = first.n.dot(piece.n);
      if (std::abs(cosine) <= flush) continue;
      first_of[k] = j;
      const double side = cosine > 0 ? 1 : -1;
      first.area += side * piece.area;
      if ((first.n - side * piece.n).norm() >= same_direction) first.n = first.area.normalized();
    }
  }
  for (std::size_t k = 0; k < at_node.size(); ++k) {
    add(node, {at_node[k].wall, at_node[first_of[k]].n});
    if (!is_free || first_of[k] != k) continue;
    for (std::size_t j = 0; j < k; ++j) {
      if (first_of[j] != j) continue;
      note_corner(at_node[j], at_node[k], grid.node(nodes_[node].grid_node));
    }
  }
}

template <int dim>
void WallConditions<dim>::note_corner(const SlipPiece& a, const SlipPiece& b,
                                      const Vector<dim>& place) {
  const double angle = degrees(std::acos(std::clamp(a.n.dot(b.n), -1.0, 1.0)));
  if (angle >= steep_angle) return;
  auto corner = std::find_if(corners_.begin(), corners_.end(), [&](const Corner& each) {
    return each.walls[0] == a.wall && each.walls[1] == b.wall;
  });
  if (corner == corners_.end()) {
    corners_.push_back({{a.wall, b.wall}, 0, angle, angle, place});
    corner = corners_.end() - 1;
  }
  ++corner->num_nodes;
  corner->least = std::min(corner->least, angle);
  corner->largest = std::max(corner->largest, angle);
}

template <int dim>
std::vector<std::string> WallConditions<dim>::corner_warnings() const {
  std::vector<std::string> warnings;
  for (const Corner& corner : corners_) {
    const WallSettings& wall = walls_[corner.walls[0]];
    const bool bends = corner.walls[0] == corner.walls[1];
    const std::string what =
        bends ? fmt::format("\"{}\" bends", wall.group)
              : fmt::format("\"{}\" and \"{}\" meet", wall.group, walls_[corner.walls[1]].group);
    const std::string angles = corner.largest - corner.least < 0.1
                                   ? fmt::format("{:.3g}", corner.largest)
                                   : fmt::format("{:.3g} to {:.3g}", corner.least, corner.largest);
    warnings.push_back(fmt::format(
        "{}: {} {} {} degrees at {} grid nodes, the first at ({:.6g}): soil cannot slide across "
        "this corner; within one group a bend below {} degrees does not hold soil, and one of "
        "\"rigid_walls\" holds at no corner",
        wall.where, what, bends ? "by" : "at", angles, corner.num_nodes,
        fmt::join(corner.place.data(), corner.place.data() + dim, ", "), corner_angle));
  }
  return warnings;
}

template <int dim>
std::size_t WallConditions<dim>::index_of(std::int32_t grid_node) const {
  const auto found =
      std::lower_bound(nodes_.begin(), nodes_.end(), grid_node,
                       [](const Node& a, std::int32_t b) { return a.grid_node < b; });
  return static_cast<std::size_t>(found - nodes_.begin());
}

template <int dim>
bool WallConditions<dim>::holds(std::int32_t grid_node) const {
  const std::size_t k = index_of(grid_node);
  return k < nodes_.size() && nodes_[k].grid_node == grid_node;
}

template <int dim>
bool WallConditions<dim>::hold_alike(std::int32_t a, std::int32_t b) const {
  const bool held = holds(a);
  if (held != holds(b)) return false;
  if (!held) return true;
  constexpr double round_off = 1e-12;
  const Node& one = nodes_[index_of(a)];
  const Node& other = nodes_[index_of(b)];
  return std::equal(one.holds, one.holds + one.num_holds, other.holds,
                    other.holds + other.num_holds, [](const Hold& p, const Hold& q) {
                      return p.wall == q.wall && (p.n - q.n).norm() < round_off;
                    });
}

// Remove the direction of `hold` from the range of the node's projector.
template <int dim>
void WallConditions<dim>::add(std::size_t k, const Hold& hold) {
  Node& node = nodes_[k];
  const Vector<dim> rest = node.Q * hold.n;
  static const double flush = std::sin(radians(flush_angle));
  if (node.num_holds == dim || rest.norm() < flush) {
    repetitions_.push_back({k, {hold.wall, (hold.n - rest).normalized()}});
    return;
  }
  const Vector<dim> d = rest.normalized();
  node.Q -= d * d.transpose();
  node.holds[node.num_holds++] = hold;
  if (node.num_holds == dim) node.Q.setZero();
}

template <int dim>
void WallConditions<dim>::set_shares(Node& node) {
  Eigen::Matrix<double, dim, Eigen::Dynamic, 0, dim, dim> N(dim, node.num_holds);
  for (int k = 0; k < node.num_holds; ++k) N.col(k) = node.holds[k].n;
  node.shares.topRows(node.num_holds) = (N.transpose() * N).inverse() * N.transpose();
}

// The displacements of the walls in a step, and the largest of them [m].
template <int dim>
double WallConditions<dim>::take_steps(double time, double dt) {
  double largest = 0;
  for (std::size_t w = 0; w < walls_.size(); ++w) {
    const WallMotion& motion = walls_[w].motion;
    if (!motion.moves()) continue;
    steps_[w] = motion.displacement<dim>(time + dt) - motion.displacement<dim>(time);
    largest = std::max(largest, steps_[w].norm());
  }
  return largest;
}

template <int dim>
void WallConditions<dim>::move_nodes() {
  for (Node& node : nodes_) {
    node.w.setZero();  // w . n_k = step . n_k, w in the range of the n_k
    for (int k = 0; k < node.num_holds; ++k) {
      const Hold& hold = node.holds[k];
      node.w += hold.n.dot(steps_[hold.wall]) * node.shares.row(k).transpose();
    }
  }
}

template <int dim>
bool WallConditions<dim>::any_moves() const {
  return std::any_of(walls_.begin(), walls_.end(),
                     [](const WallSettings& wall) { return wall.motion.moves(); });
}

template <int dim>
void WallConditions<dim>::begin_step(double time, double dt) {
  if (!any_moves()) return;
  move_ = take_steps(time, dt) > 0;
  move_nodes();
}

template <int dim>
void WallConditions<dim>::require_agreement(double start, double end) {
  if (!any_moves() || repetitions_.empty()) return;
  const std::vector<double> times = corner_times(walls_, start, end);
  for (std::size_t k = 0; k + 1 < times.size(); ++k) {
    const double largest = take_steps(times[k], times[k + 1] - times[k]);
    move_nodes();
    for (const Repetition& repetition : repetitions_) {
      require_agreement(repetition, same_motion * largest, times[k]);
    }
  }
  std::fill(steps_.begin(), steps_.end(), Vector<dim>::Zero());
  move_nodes();
}

template <int dim>
void WallConditions<dim>::require_agreement(const Repetition& repetition, double tolerance,
                                            double time) const {
  const Node& node = nodes_[repetition.node];
  const Hold& hold = repetition.hold;
  if (std::abs(hold.n.dot(node.w - steps_[hold.wall])) <= tolerance) return;
  throw ConfigError(fmt::format(
      "{}: found a motion of \"{}\" from {} s on that differs from that of \"{}\", which holds "
      "grid node {} in the same direction, allowed: equal motions where walls meet",
      walls_[hold.wall].where, walls_[hold.wall].group, time, walls_[node.holds[0].wall].group,
      node.grid_node));
}

template <int dim>
void WallConditions<dim>::select(const GridNodes<dim>& nodes) {
  selected_.clear();
  constrained_.clear();
  projectors_.clear();
  for (std::int32_t field = 0; field < nodes.num_fields; ++field) {
    for (std::size_t k = 0; k < nodes_.size(); ++k) {
      const std::int32_t node = nodes_[k].grid_node + field * nodes.num_places;
      const std::int32_t i = nodes.active[node];
      if (i < 0 || nodes.grid_node[i] != node) continue;  // inactive, or it joined another one
      selected_.push_back(k);
      constrained_.push_back(i);
      projectors_.push_back(nodes_[k].Q);
    }
  }
}

template <int dim>
void WallConditions<dim>::project(std::span<double> x) const {
  for (std::size_t k = 0; k < constrained_.size(); ++k) {
    Eigen::Map<Vector<dim>> x_i(x.data() + static_cast<std::size_t>(constrained_[k]) * dim);
    x_i = (projectors_[k] * x_i).eval();
  }
}

template <int dim>
void WallConditions<dim>::impose(std::span<double> x, double scale) const {
  project(x);
  for (std::size_t k = 0; k < constrained_.size(); ++k) {
    Eigen::Map<Vector<dim>> x_i(x.data() + static_cast<std::size_t>(constrained_[k]) * dim);
    x_i += scale * nodes_[selected_[k]].w;
  }
}

template <int dim>
std::vector<Vector<dim>> WallConditions<dim>::forces(std::span<const double> r,
                                                     const SharedNodes& shared) const {
  std::vector<Vector<dim>> sums(walls_.size(), Vector<dim>::Zero());
  for (std::size_t k = 0; k < constrained_.size(); ++k) {
    if (!shared.owns(constrained_[k])) continue;
    const Node& node = nodes_[selected_[k]];
    const Eigen::Map<const Vector<dim>> r_i(r.data() +
                                            static_cast<std::size_t>(constrained_[k]) * dim);
    for (int m = 0; m < node.num_holds; ++m) {
      sums[node.holds[m].wall] += node.shares.row(m).dot(r_i) * node.holds[m].n;
    }
  }
  return sums;
}

template class WallConditions<2>;
template class WallConditions<3>;

}  // namespace gabion::mpm
