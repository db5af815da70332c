// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/ranks/point_rows.hpp"

#include <algorithm>
#include <numeric>
#include <span>

#include "common/hdf5/array_file.hpp"
#include "common/mechanics/petsc/packet.hpp"
#include "common/mechanics/ranks/sum.hpp"

namespace gabion::mpm {

namespace {

// First id of the share of a rank, and of the one behind the last: the number of ids.
std::int64_t first_id(std::int64_t num_ids, int rank, int num_ranks) {
  const std::int64_t chunk = ArrayFile::chunk_rows;
  const std::int64_t num_chunks = (num_ids + chunk - 1) / chunk;
  return std::min(num_ids, num_chunks * rank / num_ranks * chunk);
}

}  // namespace

template <int dim>
PointRows::PointRows(MPI_Comm comm, const MaterialPoints<dim>& points) : comm_(comm) {
  const int size = num_ranks(comm_);
  if (size == 1) return;
  for (int rank = 0; rank <= size; ++rank) {
    const std::int64_t id = first_id(points.body_ids.back(), rank, size);
    const auto place = std::lower_bound(points.id.begin(), points.id.end(), id);
    starts_.push_back(static_cast<std::int32_t>(place - points.id.begin()));
  }
  const std::vector<std::int64_t> ids = exchange<std::int64_t>(points.id, 1);
  order_.resize(ids.size());
  std::iota(order_.begin(), order_.end(), 0);
  std::sort(order_.begin(), order_.end(),
            [&](std::size_t a, std::size_t b) { return ids[a] < ids[b]; });
}

template <class Value>
std::vector<Value> PointRows::exchange(std::span<const Value> own, std::size_t width) const {
  Packets out;
  for (int rank = 0; rank < num_ranks(comm_); ++rank) {
    const auto first = static_cast<std::size_t>(starts_[rank]);
    const std::size_t count = static_cast<std::size_t>(starts_[rank + 1]) - first;
    if (count > 0) out[rank].put_all(own.subspan(first * width, count * width));
  }
  Packets in = send_packets(comm_, out);
  out.clear();
  std::vector<Value> arrived;
  for (auto& [rank, packet] : in) {
    std::vector<Value> part(packet.bytes().size() / sizeof(Value));
    packet.take_all(part);
    arrived.insert(arrived.end(), part.begin(), part.end());
  }
  return arrived;
}

std::vector<double> PointRows::gather_rows(std::vector<double> own, int width) const {
  if (num_ranks(comm_) == 1) return own;
  const auto columns = static_cast<std::size_t>(width);
  const std::vector<double> arrived = exchange<double>(own, columns);
  own = {};
  std::vector<double> rows;
  rows.reserve(arrived.size());
  for (const std::size_t p : order_) {
    const double* const row = arrived.data() + p * columns;
    rows.insert(rows.end(), row, row + columns);
  }
  return rows;
}

template PointRows::PointRows(MPI_Comm, const MaterialPoints<2>&);
template PointRows::PointRows(MPI_Comm, const MaterialPoints<3>&);

}  // namespace gabion::mpm
