// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/contact/side_fields.hpp"

#include <algorithm>
#include <array>
#include <limits>
#include <utility>

#include "common/mechanics/ranks/sum.hpp"
#include "mpm_solver/contact/goes_through.hpp"
#include "mpm_solver/grid/node_bits.hpp"

namespace gabion::mpm {

namespace {

// Share of the shortest edge of a cell: a node at no more than this distance before a face lies on
// it.
constexpr double tiny_share = 1e-9;

// Share of that edge: lines of sight start this far beside the points. Otherwise lines of sight
// along the grid would pass through corners of simplices, which often lie on it.
constexpr double aside_share = 1e-6;

// A point is at an end of a wall where the nearest face is seen at more than 60 degrees off its
// normal.
constexpr double before_cosine = 0.5;

// The place that stands for a side of a node within a wall lies at this share of the line from the
// nearest place of the face to the face's middle, so that it is before no other face of a corner.
constexpr double inward_share = 1e-3;

constexpr std::int32_t unknown = -1;
constexpr std::int32_t no_face = -2;

// Faces that a line of sight goes through, from their front and from their back.
struct Sight {
  int entered = 0, left = 0;
  std::int32_t last = no_face;  // that was entered

  bool ends_within() const { return entered > left; }
  bool is_odd() const { return entered % 2 != 0; }
};

// Faces of thin walls, some of which a sight may go through.
template <int dim>
struct WallFaces {
  std::span<const std::int32_t> some;
  std::span<const Simplex<dim>> simplices;
  std::span<const Vector<dim>> vertices;
  std::span<const SimplexBounds<dim>> bounds;
  double tiny;  // distance at which a place is on a face [m]
};

template <int dim>
Sight sight(const Vector<dim>& x, const Vector<dim>& y, const WallFaces<dim>& faces) {
  Sight found;
  double last_share = -1;
  for (const std::int32_t s : faces.some) {
    const Vector<dim>& n = faces.bounds[s].normal;
    const auto corners = corners_of<dim>(faces.simplices[s], faces.vertices);
    const double from = (x - corners[0]).dot(n), to = (y - corners[0]).dot(n);
    const bool enters = from > faces.tiny;
    if (enters == (to > faces.tiny) || !goes_through(x, y, corners)) continue;
    if (!enters) {
      ++found.left;
      continue;
    }
    ++found.entered;
    const double share = from / (from - to);
    if (share > last_share) {
      last_share = share;
      found.last = s;
    }
  }
  return found;
}

}  // namespace

template <int dim>
bool can_double_nodes(const BackgroundGrid<dim>& grid) {
  constexpr std::int32_t most = std::numeric_limits<std::int32_t>::max() / 2;
  return grid.box && grid.num_nodes_total() <= most;
}

template <int dim>
SideFields<dim>::SideFields(MPI_Comm comm, Faces<dim> faces, std::vector<FacePair> pairs,
                            const BackgroundGrid<dim>& grid)
    : comm_(comm),
      grid_(grid),
      faces_(std::move(faces)),
      pairs_(std::move(pairs)),
      which_(members(pairs_)) {
  for (const std::int32_t s : which_) surfaces_.push_back(faces_.surface[s]);
  surfaces_.erase(std::unique(surfaces_.begin(), surfaces_.end()), surfaces_.end());
  reach_ = (grid.basis == Basis::linear ? 1 : 2) * grid.box->spacing.norm();
  tiny_ = tiny_share * grid.box->spacing.minCoeff();
}

// Take the accepted places of the surfaces, and list the faces that act.
template <int dim>
void SideFields<dim>::follow(const Surfaces<dim>& surfaces) {
  bool same = hash_.has_value();
  std::vector<char> acts(faces_.first_vertex.size(), 0);
  for (const std::size_t k : surfaces_) {
    const auto x = surfaces.accepted_vertices(k);
    acts[k] = x.empty() ? 0 : 1;
    if (faces_.move(k, x)) same = false;
  }
  std::vector<Simplex<dim>> acting;
  std::vector<std::int32_t> place(faces_.simplices.size(), no_face);
  for (const std::int32_t s : which_) {
    if (acts[faces_.surface[s]] == 0) continue;
    place[s] = static_cast<std::int32_t>(acting.size());
    acting.push_back(faces_.simplices[s]);
  }
  if (same && acting == acting_) return;
  acting_ = std::move(acting);
  acting_pairs_.clear();
  for (const auto& [front, back, thickness] : pairs_) {
    if (place[front] < 0 || place[back] < 0) continue;
    acting_pairs_.push_back({place[front], place[back], thickness});
  }
  bounds_ = bounds_of<dim>(acting_, faces_.vertices);
  hash_.emplace(acting_, faces_.vertices, 2 * reach_);
}

// The face that is nearest to a node (of several equally near ones that which the node is before),
// or no_face.
template <int dim>
std::int32_t SideFields<dim>::face_of(std::int32_t node) {
  std::int32_t& known = face_of_.at(node);
  if (known != unknown) return known;
  const Vector<dim> x = grid_.node(node);
  double nearest = std::numeric_limits<double>::infinity(), most_before = 0;
  known = no_face;
  for (const std::int32_t s : hash_->near(x)) {
    const auto corners = corners_of<dim>(acting_[s], faces_.vertices);
    const double distance = (closest_place<dim>(corners, x).x - x).norm();
    const double before = (x - corners[0]).dot(bounds_[s].normal);
    const bool as_near = distance < nearest + tiny_ && before > most_before + tiny_;
    if (distance >= nearest - tiny_ && !as_near) continue;
    nearest = std::min(distance, nearest);
    most_before = before;
    known = s;
  }
  return known;
}

// Whether a point sees a node through thin walls, so that it is not on the side that the node's
// face looks to. Walls that were entered and not left again end around the node: then the sight to
// a place just before that face tells the side, in corners too, where the faces that were entered
// look another way than it. A wall may be left through an end, which is no face.
template <int dim>
bool SideFields<dim>::is_far_side(const Vector<dim>& x, std::int32_t node,
                                  std::span<const std::int32_t> faces) {
  const Vector<dim> y = grid_.node(node);
  const auto sight_to = [&](const Vector<dim>& to) {
    return sight<dim>(x, to, {faces, acting_, faces_.vertices, bounds_, tiny_});
  };
  const Sight found = sight_to(y);
  if (!found.ends_within()) return found.is_odd();
  const std::int32_t s = face_of(node);
  const Vector<dim>& n = bounds_[s].normal;
  const auto corners = corners_of<dim>(acting_[s], faces_.vertices);
  Vector<dim> middle = Vector<dim>::Zero();
  for (const Vector<dim>& corner : corners) middle += corner / dim;
  Vector<dim> before = closest_place<dim>(corners, y).x;
  before += inward_share * (middle - before) + aside_share * grid_.box->spacing.minCoeff() * n;
  const Sight again = sight_to(before);
  if (!again.ends_within()) return again.is_odd();
  return bounds_[found.last].normal.dot(n) < 0;
}

template <int dim>
bool SideFields<dim>::is_at_end(const Vector<dim>& x) const {
  double nearest = reach_;
  bool at_end = false;
  for (const std::int32_t s : hash_->near(x)) {
    if (bounds_[s].is_beyond(x, nearest + tiny_)) continue;
    const auto corners = corners_of<dim>(acting_[s], faces_.vertices);
    const Vector<dim> path = x - closest_place<dim>(corners, x).x;
    const double distance = path.norm();
    if (distance > nearest + tiny_) continue;
    const bool before = path.dot(bounds_[s].normal) >= before_cosine * distance;
    at_end = distance < nearest - tiny_ ? !before : at_end && !before;
    nearest = std::min(nearest, distance);
  }
  return at_end;
}

template <int dim>
typename SideFields<dim>::NearGroup SideFields<dim>::look_at(const CellGroup& group,
                                                             std::span<const std::int32_t> faces,
                                                             const MaterialPoints<dim>& points,
                                                             const PointWeights<dim>& weights) {
  NearGroup near;
  const auto nodes = weights.nodes_of(group);
  const Vector<dim> beside = aside_share * grid_.box->spacing.minCoeff() * aside<dim>();
  for (std::int32_t e = group.first; e < group.last; ++e) {
    const Vector<dim> x = points.x[weights.point[e]] + beside;
    Sides sides = 0;
    for (std::size_t k = 0; k < nodes.size(); ++k) {
      if (is_far_side(x, nodes[k], faces)) sides |= Sides{1} << k;
    }
    near.sides.push_back(sides);
    const bool at_end = is_at_end(x);
    for (int i = 0; i < weights.num_nodes(e); ++i) {
      if (weights.N_of(e)[i] <= 0) continue;
      const int k = weights.local_of(e)[i];
      char& reached = reached_.at(nodes[k]);
      reached |= (sides >> k & 1) != 0 ? by_far_side : by_near_side;
      if (at_end) reached |= by_end;
    }
  }
  return near;
}

// Faces that a sight from a point of the group to one of its nodes may go through.
template <int dim>
std::vector<std::int32_t> SideFields<dim>::faces_near(const CellGroup& group) const {
  const Vector<dim> middle = grid_.node(grid_.cell(group.cell)[0]) + grid_.box->spacing / 2;
  std::vector<std::int32_t> faces;
  for (const std::int32_t s : hash_->near(middle)) {
    if (!bounds_[s].is_beyond(middle, 2 * reach_)) faces.push_back(s);
  }
  return faces;
}

// Whether there are points of any ranks before both faces of a pair, so that a node may be doubled.
template <int dim>
bool SideFields<dim>::has_two_sides(const MaterialPoints<dim>& points,
                                    const PointWeights<dim>& weights) const {
  std::vector<std::int32_t> has_soil(acting_.size(), 0);
  for (const CellGroup& group : weights.groups) {
    for (const std::int32_t s : faces_near(group)) {
      const Vector<dim>& corner = faces_.vertices[acting_[s][0]];
      for (std::int32_t e = group.first; e < group.last && has_soil[s] == 0; ++e) {
        const Vector<dim> path = points.x[weights.point[e]] - corner;
        has_soil[s] = path.dot(bounds_[s].normal) > 0 ? 1 : 0;
      }
    }
  }
  max_over_ranks(comm_, std::span<std::int32_t>(has_soil));
  return std::ranges::any_of(acting_pairs_, [&](const FacePair& pair) {
    return has_soil[pair.front] != 0 && has_soil[pair.back] != 0;
  });
}

// Look at the groups that are near thin walls.
template <int dim>
void SideFields<dim>::look(const MaterialPoints<dim>& points, const PointWeights<dim>& weights) {
  near_.clear();
  reached_.assign(grid_.num_nodes_total(), 0);
  face_of_.assign(grid_.num_nodes_total(), unknown);
  for (std::int32_t g = 0; g < std::ssize(weights.groups); ++g) {
    const CellGroup& group = weights.groups[g];
    const std::vector<std::int32_t> faces = faces_near(group);
    if (faces.empty()) continue;
    near_.push_back(look_at(group, faces, points, weights));
    near_.back().group = g;
  }
}

// Box around the nodes that points near thin walls weigh on, of all ranks.
template <int dim>
Eigen::AlignedBox<double, dim> SideFields<dim>::box_of_reached() {
  Eigen::AlignedBox<double, dim> box;
  reached_.for_each(
      [&](std::size_t node, char) { box.extend(grid_.node(static_cast<std::int32_t>(node))); });
  std::array<double, 2 * dim> ends;
  for (int d = 0; d < dim; ++d) {
    ends[d] = -box.min()[d];
    ends[dim + d] = box.max()[d];
  }
  max_over_ranks(comm_, std::span<double>(ends));
  for (int d = 0; d < dim; ++d) {
    box.min()[d] = -ends[d];
    box.max()[d] = ends[dim + d];
  }
  return box;
}

// Points that are far from all thin walls are on the near side of all their nodes. Where other
// ranks reach some of these, only the box around all those tells.
template <int dim>
void SideFields<dim>::reach_from_afar(const PointWeights<dim>& weights) {
  const bool alone = num_ranks(comm_) == 1;
  const Eigen::AlignedBox<double, dim> box =
      alone ? Eigen::AlignedBox<double, dim>() : box_of_reached();
  auto near = near_.begin();
  for (std::int32_t g = 0; g < std::ssize(weights.groups); ++g) {
    if (near != near_.end() && near->group == g) {
      ++near;
      continue;
    }
    for (const std::int32_t node : weights.nodes_of(weights.groups[g])) {
      const bool may_count = alone ? reached_[node] != 0 : box.contains(grid_.node(node));
      if (may_count) reached_.at(node) |= by_near_side;
    }
  }
}

// The nodes of groups near thin walls, and all others that are reached.
template <int dim>
void SideFields<dim>::list_nodes(const PointWeights<dim>& weights) {
  listed_.clear();
  for (const NearGroup& near : near_) {
    const auto nodes = weights.nodes_of(weights.groups[near.group]);
    listed_.insert(listed_.end(), nodes.begin(), nodes.end());
  }
  reached_.for_each(
      [&](std::size_t node, char) { listed_.push_back(static_cast<std::int32_t>(node)); });
  std::ranges::sort(listed_);
  listed_.erase(std::unique(listed_.begin(), listed_.end()), listed_.end());
}

template <int dim>
void SideFields<dim>::count_doubled() {
  num_doubled_ = 0;
  for (std::size_t k = 0; k < listed_.size(); ++k) {
    const bool counts = is_doubled(listed_[k]) && shared_.owns(static_cast<std::int32_t>(k));
    num_doubled_ += counts ? 1 : 0;
  }
  sum_over_ranks(comm_, std::span<std::int32_t>(&num_doubled_, 1));
}

template <int dim>
std::vector<std::int32_t> SideFields<dim>::numbers_of_doubled() const {
  std::vector<std::int32_t> numbers;
  if (num_ranks(comm_) == 1) return numbers;
  for (const std::int32_t node : listed_) {
    if (is_doubled(node)) numbers.insert(numbers.end(), {node, node + grid_.num_nodes_total()});
  }
  return numbers;
}

template <int dim>
std::vector<std::int32_t> SideFields<dim>::split(const Surfaces<dim>& surfaces,
                                                 const MaterialPoints<dim>& points,
                                                 PointWeights<dim>& weights) {
  follow(surfaces);
  num_doubled_ = 0;
  if (acting_pairs_.empty() || !has_two_sides(points, weights)) return {};
  look(points, weights);
  reach_from_afar(weights);
  list_nodes(weights);
  shared_ = SharedNodes(comm_, listed_, grid_.num_nodes_total());
  join_bits(comm_, shared_, std::span<const std::int32_t>(listed_), reached_);
  count_doubled();
  if (num_doubled_ == 0) return {};
  part_groups(weights);
  return numbers_of_doubled();
}

template bool can_double_nodes<2>(const BackgroundGrid<2>&);
template bool can_double_nodes<3>(const BackgroundGrid<3>&);
template class SideFields<2>;
template class SideFields<3>;

}  // namespace gabion::mpm
