// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/contact/group_nodes.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

#include "mpm_solver/contact/contact_plane.hpp"
#include "mpm_solver/contact/group_clouds.hpp"

namespace gabion::mpm {

namespace {

// Contact areas below this share of the area of a cell's facet carry nothing.
constexpr double least_area = 1e-6;

// The smaller surface of two gives the area of the contact where it is less than this share of the
// other one.
constexpr double same_area = 0.9;

// Places of points relative to a node, by the cell size.
template <int dim>
std::vector<Vector<dim>> relative_places(const SoilSurface<dim>& soil,
                                         const GroupClouds<dim>& clouds,
                                         std::span<const std::int32_t> points,
                                         const Vector<dim>& x) {
  std::vector<Vector<dim>> places;
  for (const std::int32_t p : points) places.push_back((clouds.x(p) - x) / soil.cell_size);
  return places;
}

// A cloud with fewer points says little of the surface between the bodies.
template <int dim>
constexpr std::size_t few_points = 3 << (dim - 1);

// The points of a cloud; where they are few, also those of the clouds of the group around it.
template <int dim>
std::vector<std::int32_t> points_about(const SoilSurface<dim>& soil, const GroupClouds<dim>& search,
                                       std::int32_t place, const GroupCloud<dim>& cloud) {
  std::vector<std::int32_t> points = cloud.points;
  if (points.size() < few_points<dim>) {
    for (const std::int32_t other : places_around(soil.grid, place, 1)) {
      const SharedPlace<dim>* const shared = search.find(other);
      if (shared == nullptr) continue;
      const auto& clouds = shared->clouds;
      const auto same = std::ranges::find(clouds, cloud.group, &GroupCloud<dim>::group);
      if (same != clouds.end())
        points.insert(points.end(), same->points.begin(), same->points.end());
    }
  }
  std::ranges::sort(points);
  points.erase(std::unique(points.begin(), points.end()), points.end());
  return points;
}

/// Points of both groups around a contact node.
struct NearPoints {
  std::vector<std::int32_t> first, second;
};

// Distance of the contact spheres of the nearest points, < 0: they overlap.
template <int dim>
double nearest_spheres(const GroupClouds<dim>& clouds, const NearPoints& near) {
  double nearest = std::numeric_limits<double>::infinity();
  for (const std::int32_t p : near.first) {
    for (const std::int32_t q : near.second) {
      nearest = std::min(nearest,
                         (clouds.x(q) - clouds.x(p)).norm() - clouds.radius(p) - clouds.radius(q));
    }
  }
  return nearest;
}

// Gap between the contact spheres of both along n.
template <int dim>
double gap_along(const Vector<dim>& n, const GroupClouds<dim>& clouds, const NearPoints& near) {
  double highest = -std::numeric_limits<double>::infinity(), lowest = -highest;
  for (const std::int32_t p : near.first) {
    highest = std::max(highest, n.dot(clouds.x(p)) + clouds.radius(p));
  }
  for (const std::int32_t p : near.second) {
    lowest = std::min(lowest, n.dot(clouds.x(p)) - clouds.radius(p));
  }
  return lowest - highest;
}

template <int dim>
GroupNode<dim> node_between(const SoilSurface<dim>& soil, const GroupClouds<dim>& search,
                            const SharedPlace<dim>& shared, const GroupCloud<dim>& a,
                            const GroupCloud<dim>& b) {
  GroupNode<dim> node{.place = shared.place};
  node.modulus = std::min(a.modulus, b.modulus);
  const NearPoints near{points_about(soil, search, shared.place, a),
                        points_about(soil, search, shared.place, b)};
  const Vector<dim> x = soil.grid.node(shared.place);
  const auto first = relative_places(soil, search, near.first, x);
  const auto second = relative_places(soil, search, near.second, x);
  Vector<dim> guess = a.gradient - b.gradient;
  if (!(guess.norm() > 0)) guess = second.front() - first.front();
  if (!(guess.norm() > 0)) guess = Vector<dim>::UnitX();
  const auto plane = plane_between<dim>({first, second}, guess.normalized());
  node.n = plane.n;
  node.separates = plane.separates;
  const double nearest = nearest_spheres(search, near);
  node.overlap = std::max(0.0, -nearest);
  node.gap = node.separates ? gap_along(node.n, search, near) : std::max(0.0, nearest);
  return node;
}

/// Surfaces of two groups at a node, seen along a normal [m^2].
struct TwoAreas {
  double first = 0, second = 0;
};

template <int dim>
TwoAreas areas_along(const Vector<dim>& n, const SharedPlace<dim>& shared, const GroupPair& pair) {
  TwoAreas areas;
  for (const GroupCloud<dim>& cloud : shared.clouds) {
    if (cloud.group == pair.first) areas.first = n.dot(cloud.gradient);
    if (cloud.group == pair.second) areas.second = -n.dot(cloud.gradient);
  }
  return areas;
}

// Each group has its own area at a node. Their mean adds up to the area of a flat contact wherever
// that lies in the cells; at the rim of the smaller surface its own area does so.
template <int dim>
double contact_area(const SoilSurface<dim>& soil, const GroupClouds<dim>& search,
                    const GroupNode<dim>& node, const GroupPair& pair) {
  const int reach = soil.grid.basis == Basis::linear ? 1 : 2;
  TwoAreas around;
  for (const std::int32_t place : places_around(soil.grid, node.place, reach)) {
    const SharedPlace<dim>* const shared = search.find(place);
    if (shared == nullptr) continue;
    const TwoAreas own = areas_along(node.n, *shared, pair);
    around.first += own.first;
    around.second += own.second;
  }
  const TwoAreas own = areas_along(node.n, *search.find(node.place), pair);
  if (!(around.first > 0) || !(around.second > 0)) return 0;
  const double most = std::max(around.first, around.second);
  const double ratio = std::min(around.first, around.second) / most;
  const double larger = std::clamp((ratio - same_area) / (1 - same_area), 0.0, 1.0) / 2;
  const double first = around.first < around.second ? 1 - larger : larger;
  return first * own.first + (1 - first) * own.second;
}

}  // namespace

template <int dim>
std::vector<std::int32_t> places_around(const BackgroundGrid<dim>& grid, std::int32_t place,
                                        int reach) {
  using Index = typename BoxGrid<dim>::Index;
  const BoxGrid<dim>& box = *grid.box;
  const Index middle =
      box.lattice_position(box.node_position(place)).array().round().template cast<int>();
  const Index low = (middle.array() - reach).max(0);
  const Index high = (middle.array() + reach).min(box.num_cells.array());
  std::vector<std::int32_t> places;
  for (Index at = low;;) {
    places.push_back(box.node(at));
    int d = 0;
    for (; d < dim; ++d) {
      if (++at[d] <= high[d]) break;
      at[d] = low[d];
    }
    if (d == dim) return places;
  }
}

template <int dim>
std::vector<GroupNode<dim>> find_contact_nodes(const SoilSurface<dim>& soil,
                                               const BodyGroups& groups,
                                               const GroupsAtNodes<dim>& at_nodes) {
  const GroupClouds<dim> search(soil, groups, at_nodes);
  const double facet = std::pow(soil.cell_size, dim - 1);
  std::vector<GroupNode<dim>> nodes;
  for (const SharedPlace<dim>& shared : search.places()) {
    if (!shared.owned) continue;
    for (std::size_t k = 0; k < groups.pairs.size(); ++k) {
      const GroupPair& pair = groups.pairs[k];
      const auto cloud_of = [&](std::int32_t group) {
        const auto found = std::ranges::find(shared.clouds, group, &GroupCloud<dim>::group);
        const bool weighs = found != shared.clouds.end() && !found->points.empty();
        return weighs ? &*found : nullptr;
      };
      const GroupCloud<dim>*const first = cloud_of(pair.first), *const second =
                                                                    cloud_of(pair.second);
      if (first == nullptr || second == nullptr) continue;
      GroupNode<dim> node = node_between(soil, search, shared, *first, *second);
      node.pair = static_cast<std::int32_t>(k);
      node.first = soil.nodes.active[at_nodes.node(shared.place, pair.first)];
      node.second = soil.nodes.active[at_nodes.node(shared.place, pair.second)];
      node.area = contact_area(soil, search, node, pair);
      if (node.area > least_area * facet) nodes.push_back(node);
    }
  }
  return nodes;
}

template std::vector<std::int32_t> places_around<2>(const BackgroundGrid<2>&, std::int32_t, int);
template std::vector<std::int32_t> places_around<3>(const BackgroundGrid<3>&, std::int32_t, int);
template std::vector<GroupNode<2>> find_contact_nodes<2>(const SoilSurface<2>&, const BodyGroups&,
                                                         const GroupsAtNodes<2>&);
template std::vector<GroupNode<3>> find_contact_nodes<3>(const SoilSurface<3>&, const BodyGroups&,
                                                         const GroupsAtNodes<3>&);

}  // namespace gabion::mpm
