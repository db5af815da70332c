// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/ranks/migration.hpp"

#include <span>

#include "common/base/reserve.hpp"
#include "common/mechanics/ranks/packet.hpp"
#include "common/mechanics/ranks/sum.hpp"

namespace gabion::mpm {

namespace {

template <class Value>
void put_value(const Value& value, Packet& packet) {
  packet.put(value);
}
template <int dim>
void put_value(const MaterialState<dim>& state, Packet& packet) {
  for_each_history_field<dim>([&](const char*, auto member) { packet.put(state.*member); });
}

template <class Value>
void take_value(Packet& packet, Value& value) {
  value = packet.take<Value>();
}
template <int dim>
void take_value(Packet& packet, MaterialState<dim>& state) {
  for_each_history_field<dim>([&]<class Value>(const char*, Value MaterialState<dim>::*member) {
    state.*member = packet.take<Value>();
  });
}

template <int dim>
void put_points(std::span<const std::int32_t> which, const MaterialPoints<dim>& points,
                Packet& packet) {
  packet.put(static_cast<std::int64_t>(which.size()));
  for_each_field<dim>([&](const char*, auto field) {
    const auto& values = points.*field;
    packet.put(values.empty() ? 0 : 1);
    if (values.empty()) return;
    for (const std::int32_t p : which) put_value(values[p], packet);
  });
}

// Append the points of a packet.
template <int dim>
void take_points(Packet& packet, MaterialPoints<dim>& points) {
  const auto count = packet.take<std::int64_t>();
  for_each_field<dim>([&](const char*, auto field) {
    if (packet.take<int>() == 0) return;
    auto& values = points.*field;
    reserve_tightly(values, values.size() + static_cast<std::size_t>(count));
    for (std::int64_t k = 0; k < count; ++k) take_value(packet, values.emplace_back());
  });
}

}  // namespace

template <int dim>
std::int64_t migrate(const CellOwners<dim>& owners, MaterialPoints<dim>& points,
                     Surfaces<dim>& surfaces) {
  const int own = rank_of(owners.comm);
  std::map<int, std::vector<std::int32_t>> to;
  std::vector<std::int32_t> leaving;
  for (std::int32_t p = 0; p < points.size(); ++p) {
    const int rank = owners.of(points.cell[p]);
    if (rank == own) continue;
    to[rank].push_back(p);
    leaving.push_back(p);
  }
  Packets out;
  for (const auto& [rank, which] : to) {
    Packet& packet = out[rank];
    put_points<dim>(which, points, packet);
    std::vector<std::int64_t> ids;
    for (const std::int32_t p : which) ids.push_back(points.id[p]);
    surfaces.give(ids, packet);
  }
  remove_points<dim>(leaving, points);
  const std::size_t num_kept = points.id.size();
  for (auto& [rank, packet] : send_packets(owners.comm, out)) {
    take_points(packet, points);
    surfaces.take(packet);
  }
  if (points.id.size() > num_kept) order_points(num_kept, points);
  double moved = static_cast<double>(leaving.size());
  sum_over_ranks(owners.comm, std::span<double>(&moved, 1));
  return static_cast<std::int64_t>(moved);
}

template std::int64_t migrate<2>(const CellOwners<2>&, MaterialPoints<2>&, Surfaces<2>&);
template std::int64_t migrate<3>(const CellOwners<3>&, MaterialPoints<3>&, Surfaces<3>&);

}  // namespace gabion::mpm
