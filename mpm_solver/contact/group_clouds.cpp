// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/contact/group_clouds.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <map>

#include "common/mechanics/ranks/gather.hpp"

namespace gabion::mpm {

namespace {

// A contact looks at the clouds that are no more cells away along each axis (places_around).
constexpr double reach = 2;

template <int dim>
using Box = Eigen::AlignedBox<double, dim>;

// Boxes around the places that each rank owns, and those that it looks at.
template <int dim>
std::vector<Box<dim>> boxes_of_ranks(const SoilSurface<dim>& soil,
                                     const std::vector<SharedPlace<dim>>& places) {
  Box<dim> own;
  for (const SharedPlace<dim>& shared : places) {
    if (shared.owned) own.extend(soil.grid.node(shared.place));
  }
  std::vector<double> ends(own.min().begin(), own.min().end());
  ends.insert(ends.end(), own.max().begin(), own.max().end());
  const std::vector<double> all = gather_on_all<double>(soil.comm, ends);
  const Vector<dim> margin = (reach + 0.5) * soil.grid.box->spacing;
  std::vector<Box<dim>> boxes;
  for (std::size_t k = 0; k < all.size(); k += 2 * dim) {
    Box<dim>& box = boxes.emplace_back(Eigen::Map<const Vector<dim>>(&all[k]),
                                       Eigen::Map<const Vector<dim>>(&all[k + dim]));
    if (box.isEmpty()) continue;
    box.min() -= margin;
    box.max() += margin;
  }
  return boxes;
}

}  // namespace

template <int dim>
GroupClouds<dim>::GroupClouds(const SoilSurface<dim>& soil, const BodyGroups& groups,
                              const GroupsAtNodes<dim>& at_nodes)
    : soil_(soil), num_own_(soil.points.size()), number_(soil.nodes.num_places, -1) {
  for (const CellGroup& group : soil.weights.groups) add_nodes(group, groups, at_nodes);
  number_places();
  for (const CellGroup& group : soil.weights.groups) add_points(group, groups);
  if (num_ranks(soil.comm) > 1) add_points_of_others();
}

template <int dim>
void GroupClouds<dim>::add_nodes(const CellGroup& group, const BodyGroups& groups,
                                 const GroupsAtNodes<dim>& at_nodes) {
  for (const std::int32_t node : soil_.weights.nodes_of(group)) {
    const std::int32_t place = node % soil_.nodes.num_places;
    if (!at_nodes.is_shared(place) || number_[place] >= 0) continue;
    number_.at(place) = 0;
    SharedPlace<dim>& shared = places_.emplace_back();
    shared.place = place;
    shared.owned = at_nodes.owns(place);
    for (std::int32_t g = 0; g < std::ssize(groups.names); ++g) {
      if ((at_nodes.at(place) >> g & 1) != 0) shared.clouds.push_back({.group = g});
    }
  }
}

template <int dim>
void GroupClouds<dim>::number_places() {
  std::ranges::sort(places_, {}, [](const auto& shared) { return shared.place; });
  for (std::size_t k = 0; k < places_.size(); ++k) {
    number_.at(places_[k].place) = static_cast<std::int32_t>(k);
  }
}

template <int dim>
void GroupClouds<dim>::add_points(const CellGroup& group, const BodyGroups& groups) {
  const auto nodes = soil_.weights.nodes_of(group);
  std::vector<GroupCloud<dim>*> clouds(nodes.size(), nullptr);
  bool any = false;
  for (std::size_t k = 0; k < nodes.size(); ++k) {
    const std::int32_t number = number_[nodes[k] % soil_.nodes.num_places];
    if (number < 0) continue;
    auto& all = places_[number].clouds;
    clouds[k] = &*std::ranges::find(all, groups.of_body[group.body], &GroupCloud<dim>::group);
    any = true;
  }
  for (std::int32_t e = group.first; any && e < group.last; ++e) add_point(e, group.body, clouds);
}

template <int dim>
void GroupClouds<dim>::add_point(std::int32_t e, std::int32_t body,
                                 const std::vector<GroupCloud<dim>*>& clouds) {
  const PointWeights<dim>& weights = soil_.weights;
  const std::int32_t p = weights.point[e];
  const double volume = soil_.points.V0[p] * soil_.points.J[p];
  for (int i = 0; i < weights.num_nodes(e); ++i) {
    GroupCloud<dim>* const cloud = clouds[weights.local_of(e)[i]];
    if (cloud == nullptr) continue;
    cloud->gradient += volume * weights.grad_of(e)[i];
    if (weights.N_of(e)[i] <= 0) continue;
    cloud->points.push_back(p);
    cloud->modulus = std::min(cloud->modulus, soil_.moduli[body]);
  }
}

// Send the own parts of all clouds to the ranks that own a place near them.
template <int dim>
void GroupClouds<dim>::add_points_of_others() {
  const std::vector<Box<dim>> boxes = boxes_of_ranks(soil_, places_);
  Packets out;
  for (int rank = 0; rank < static_cast<int>(boxes.size()); ++rank) {
    if (rank == rank_of(soil_.comm) || boxes[rank].isEmpty()) continue;
    std::vector<std::int32_t> which;
    for (std::size_t k = 0; k < places_.size(); ++k) {
      if (boxes[rank].contains(soil_.grid.node(places_[k].place))) {
        which.push_back(static_cast<std::int32_t>(k));
      }
    }
    if (!which.empty()) put(which, out[rank]);
  }
  for (auto& [rank, packet] : send_packets(soil_.comm, out)) take(packet);
  number_places();
}

// Pack the points of some places, then what the places have of them.
template <int dim>
void GroupClouds<dim>::put(const std::vector<std::int32_t>& which, Packet& packet) const {
  std::map<std::int32_t, std::int32_t> number;  // of the points in the packet
  for (const std::int32_t k : which) {
    for (const GroupCloud<dim>& cloud : places_[k].clouds) {
      for (const std::int32_t p : cloud.points) number.try_emplace(p, 0);
    }
  }
  packet.put(static_cast<std::int32_t>(number.size()));
  std::int32_t next = 0;
  for (auto& [p, k] : number) {
    k = next++;
    packet.put(soil_.points.x[p]);
    packet.put(soil_.points.depth[p]);
  }
  for (const std::int32_t k : which) {
    for (const GroupCloud<dim>& cloud : places_[k].clouds) {
      if (cloud.points.empty() && cloud.gradient.isZero(0)) continue;
      packet.put(places_[k].place);
      packet.put(cloud.group);
      packet.put(cloud.gradient);
      packet.put(cloud.modulus);
      packet.put(static_cast<std::int32_t>(cloud.points.size()));
      for (const std::int32_t p : cloud.points) packet.put(number.at(p));
    }
  }
}

template <int dim>
void GroupClouds<dim>::take(Packet& packet) {
  const std::int32_t first = num_own_ + static_cast<std::int32_t>(other_x_.size());
  for (auto count = packet.take<std::int32_t>(); count > 0; --count) {
    other_x_.push_back(packet.take<Vector<dim>>());
    other_radius_.push_back(packet.take<double>());
  }
  while (!packet.empty()) take_clouds(first, packet);
}

// Unpack what another rank has of one cloud. @param first_point  of its points among those of other
// ranks
template <int dim>
void GroupClouds<dim>::take_clouds(std::int32_t first_point, Packet& packet) {
  const auto place = packet.take<std::int32_t>();
  if (number_[place] < 0) {
    number_.at(place) = static_cast<std::int32_t>(places_.size());
    places_.push_back({.place = place, .owned = false});
  }
  auto& clouds = places_[number_[place]].clouds;
  const auto group = packet.take<std::int32_t>();
  auto cloud = std::ranges::find(clouds, group, &GroupCloud<dim>::group);
  if (cloud == clouds.end()) cloud = clouds.insert(cloud, {.group = group});
  cloud->gradient += packet.take<Vector<dim>>();
  cloud->modulus = std::min(cloud->modulus, packet.take<double>());
  for (auto count = packet.take<std::int32_t>(); count > 0; --count) {
    cloud->points.push_back(first_point + packet.take<std::int32_t>());
  }
}

template class GroupClouds<2>;
template class GroupClouds<3>;

}  // namespace gabion::mpm
