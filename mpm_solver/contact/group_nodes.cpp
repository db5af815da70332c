// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/contact/group_nodes.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

#include "mpm_solver/contact/contact_plane.hpp"
#include "mpm_solver/grid/group_fields.hpp"

namespace gabion::mpm {

namespace {

// Share of the area of a cell's facet: smaller ones carry nothing.
constexpr double least_area = 1e-6;

// The smaller surface of two gives the area of the contact where it is less than this share of the
// other one.
constexpr double same_area = 0.9;

/// The points of one group that weigh on a node.
template <int dim>
struct Cloud {
  std::int32_t group = 0;
  std::int32_t node = 0;                       // active
  Vector<dim> gradient = Vector<dim>::Zero();  // sum of volume times grad N: outward area [m^2]
  double modulus = std::numeric_limits<double>::infinity();
  std::vector<std::int32_t> points{};
};

/// A node on which several groups weigh.
template <int dim>
struct SharedPlace {
  std::int32_t place = 0;
  std::vector<Cloud<dim>> clouds;
};

/// Finds the shared places with their clouds.
template <int dim>
class PlaceSearch {
 public:
  PlaceSearch(const SoilSurface<dim>& soil, const BodyGroups& groups)
      : soil_(soil),
        groups_(groups),
        at_nodes_(groups.of_body, soil.nodes.num_places, soil.weights),
        number_(soil.nodes.num_places, -1) {
    for (const CellGroup& group : soil.weights.groups) add_nodes(group);
    std::ranges::sort(places, {}, [](const auto& place) { return place.place; });
    for (std::size_t k = 0; k < places.size(); ++k) {
      number_.at(places[k].place) = static_cast<std::int32_t>(k);
    }
    for (const CellGroup& group : soil.weights.groups) add_points(group);
  }
  /// Number of a shared place, -1: it is none.
  std::int32_t number(std::int32_t place) const { return number_[place]; }

  std::vector<SharedPlace<dim>> places;

 private:
  void add_nodes(const CellGroup& group) {
    for (const std::int32_t node : soil_.weights.nodes_of(group)) {
      const std::int32_t place = node % soil_.nodes.num_places;
      if (!at_nodes_.is_shared(place) || number_[place] >= 0) continue;
      number_.at(place) = 0;
      SharedPlace<dim>& shared = places.emplace_back();
      shared.place = place;
      for (std::int32_t g = 0; g < std::ssize(groups_.names); ++g) {
        if ((at_nodes_.at(place) >> g & 1) == 0) continue;
        shared.clouds.push_back({.group = g, .node = soil_.nodes.active[at_nodes_.node(place, g)]});
      }
    }
  }
  void add_points(const CellGroup& group) {
    const auto nodes = soil_.weights.nodes_of(group);
    std::vector<Cloud<dim>*> clouds(nodes.size(), nullptr);
    bool any = false;
    for (std::size_t k = 0; k < nodes.size(); ++k) {
      const std::int32_t number = number_[nodes[k] % soil_.nodes.num_places];
      if (number < 0) continue;
      auto& all = places[number].clouds;
      clouds[k] = &*std::ranges::find(all, groups_.of_body[group.body], &Cloud<dim>::group);
      any = true;
    }
    for (std::int32_t e = group.first; any && e < group.last; ++e) add_point(e, group.body, clouds);
  }
  void add_point(std::int32_t e, std::int32_t body, const std::vector<Cloud<dim>*>& clouds) {
    const std::int32_t p = soil_.weights.point[e];
    const double volume = soil_.points.V0[p] * soil_.points.J[p];
    for (int i = 0; i < soil_.weights.num_nodes(e); ++i) {
      Cloud<dim>* const cloud = clouds[soil_.weights.local_of(e)[i]];
      if (cloud == nullptr) continue;
      cloud->gradient += volume * soil_.weights.grad_of(e)[i];
      if (soil_.weights.N_of(e)[i] <= 0) continue;
      cloud->points.push_back(p);
      cloud->modulus = std::min(cloud->modulus, soil_.moduli[body]);
    }
  }

  const SoilSurface<dim>& soil_;
  const BodyGroups& groups_;
  GroupsAtNodes<dim> at_nodes_;
  SparseList<std::int32_t> number_;
};

// Places of points relative to a node, by the cell size.
template <int dim>
std::vector<Vector<dim>> relative_places(const SoilSurface<dim>& soil,
                                         std::span<const std::int32_t> points,
                                         const Vector<dim>& x) {
  std::vector<Vector<dim>> places;
  for (const std::int32_t p : points) places.push_back((soil.points.x[p] - x) / soil.cell_size);
  return places;
}

// A cloud with fewer points says little of the surface between the bodies.
template <int dim>
constexpr std::size_t few_points = 3 << (dim - 1);

// The points of a cloud; where they are few, those of the clouds of the group around it besides.
template <int dim>
std::vector<std::int32_t> points_about(const SoilSurface<dim>& soil, const PlaceSearch<dim>& search,
                                       std::int32_t place, const Cloud<dim>& cloud) {
  std::vector<std::int32_t> points = cloud.points;
  if (points.size() < few_points<dim>) {
    for (const std::int32_t other : places_around(soil.grid, place, 1)) {
      const std::int32_t number = search.number(other);
      if (number < 0) continue;
      const auto& clouds = search.places[number].clouds;
      const auto same = std::ranges::find(clouds, cloud.group, &Cloud<dim>::group);
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
double nearest_spheres(const MaterialPoints<dim>& points, const NearPoints& near) {
  double nearest = std::numeric_limits<double>::infinity();
  for (const std::int32_t p : near.first) {
    for (const std::int32_t q : near.second) {
      nearest =
          std::min(nearest, (points.x[q] - points.x[p]).norm() - points.depth[p] - points.depth[q]);
    }
  }
  return nearest;
}

// Gap between the contact spheres of both along n.
template <int dim>
double gap_along(const Vector<dim>& n, const MaterialPoints<dim>& points, const NearPoints& near) {
  double highest = -std::numeric_limits<double>::infinity(), lowest = -highest;
  for (const std::int32_t p : near.first) {
    highest = std::max(highest, n.dot(points.x[p]) + points.depth[p]);
  }
  for (const std::int32_t p : near.second) {
    lowest = std::min(lowest, n.dot(points.x[p]) - points.depth[p]);
  }
  return lowest - highest;
}

template <int dim>
GroupNode<dim> node_between(const SoilSurface<dim>& soil, const PlaceSearch<dim>& search,
                            const SharedPlace<dim>& shared, const Cloud<dim>& a,
                            const Cloud<dim>& b) {
  GroupNode<dim> node{.place = shared.place, .first = a.node, .second = b.node};
  node.modulus = std::min(a.modulus, b.modulus);
  const NearPoints near{points_about(soil, search, shared.place, a),
                        points_about(soil, search, shared.place, b)};
  const Vector<dim> x = soil.grid.node(shared.place);
  const auto first = relative_places(soil, near.first, x);
  const auto second = relative_places(soil, near.second, x);
  Vector<dim> guess = a.gradient - b.gradient;
  if (!(guess.norm() > 0)) guess = second.front() - first.front();
  if (!(guess.norm() > 0)) guess = Vector<dim>::UnitX();
  const auto plane = plane_between<dim>({first, second}, guess.normalized());
  node.n = plane.n;
  node.separates = plane.separates;
  const double nearest = nearest_spheres(soil.points, near);
  node.overlap = std::max(0.0, -nearest);
  node.gap = node.separates ? gap_along(node.n, soil.points, near) : std::max(0.0, nearest);
  return node;
}

/// Surfaces of two groups at a node, seen along a normal [m^2].
struct TwoAreas {
  double first = 0, second = 0;
};

template <int dim>
TwoAreas areas_along(const Vector<dim>& n, const SharedPlace<dim>& shared, const GroupPair& pair) {
  TwoAreas areas;
  for (const Cloud<dim>& cloud : shared.clouds) {
    if (cloud.group == pair.first) areas.first = n.dot(cloud.gradient);
    if (cloud.group == pair.second) areas.second = -n.dot(cloud.gradient);
  }
  return areas;
}

// Each group has its own area at a node. Their mean adds up to the area of a flat contact wherever
// that lies in the cells; at the rim of the smaller surface its own area does so.
template <int dim>
double contact_area(const SoilSurface<dim>& soil, const PlaceSearch<dim>& search,
                    const GroupNode<dim>& node, const GroupPair& pair) {
  const int reach = soil.grid.basis == Basis::linear ? 1 : 2;
  TwoAreas around;
  for (const std::int32_t place : places_around(soil.grid, node.place, reach)) {
    const std::int32_t number = search.number(place);
    if (number < 0) continue;
    const TwoAreas own = areas_along(node.n, search.places[number], pair);
    around.first += own.first;
    around.second += own.second;
  }
  const TwoAreas own = areas_along(node.n, search.places[search.number(node.place)], pair);
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
                                               const BodyGroups& groups) {
  const PlaceSearch<dim> search(soil, groups);
  const double facet = std::pow(soil.cell_size, dim - 1);
  std::vector<GroupNode<dim>> nodes;
  for (const SharedPlace<dim>& shared : search.places) {
    for (std::size_t k = 0; k < groups.pairs.size(); ++k) {
      const GroupPair& pair = groups.pairs[k];
      const auto cloud_of = [&](std::int32_t group) {
        const auto found = std::ranges::find(shared.clouds, group, &Cloud<dim>::group);
        const bool weighs = found != shared.clouds.end() && !found->points.empty();
        return weighs ? &*found : nullptr;
      };
      const Cloud<dim>*const first = cloud_of(pair.first), *const second = cloud_of(pair.second);
      if (first == nullptr || second == nullptr) continue;
      GroupNode<dim> node = node_between(soil, search, shared, *first, *second);
      node.pair = static_cast<std::int32_t>(k);
      node.area = contact_area(soil, search, node, pair);
      if (node.area > least_area * facet) nodes.push_back(node);
    }
  }
  return nodes;
}

template std::vector<std::int32_t> places_around<2>(const BackgroundGrid<2>&, std::int32_t, int);
template std::vector<std::int32_t> places_around<3>(const BackgroundGrid<3>&, std::int32_t, int);
template std::vector<GroupNode<2>> find_contact_nodes<2>(const SoilSurface<2>&, const BodyGroups&);
template std::vector<GroupNode<3>> find_contact_nodes<3>(const SoilSurface<3>&, const BodyGroups&);

}  // namespace gabion::mpm
