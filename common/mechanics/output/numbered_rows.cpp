// SPDX-License-Identifier: BSD-3-Clause
#include "common/mechanics/output/numbered_rows.hpp"

#include <algorithm>
#include <numeric>

#include "common/hdf5/array_file.hpp"
#include "common/mechanics/ranks/packet.hpp"
#include "common/mechanics/ranks/sum.hpp"

namespace gabion {

namespace {

// First number of the share of a rank, and of the one behind the last: the end.
std::int64_t first_number(std::int64_t end, int rank, int num_ranks) {
  const std::int64_t chunk = ArrayFile::chunk_rows;
  const std::int64_t num_chunks = (end + chunk - 1) / chunk;
  return std::min(end, num_chunks * rank / num_ranks * chunk);
}

}  // namespace

NumberedRows::NumberedRows(MPI_Comm comm, std::span<const std::int64_t> numbers, std::int64_t end)
    : comm_(comm) {
  const int size = num_ranks(comm_);
  if (size == 1) return;
  for (int rank = 0; rank <= size; ++rank) {
    const auto place = std::ranges::lower_bound(numbers, first_number(end, rank, size));
    starts_.push_back(static_cast<std::int32_t>(place - numbers.begin()));
  }
  const std::vector<std::int64_t> arrived = exchange<std::int64_t>(numbers, 1);
  order_.resize(arrived.size());
  std::iota(order_.begin(), order_.end(), 0);
  std::sort(order_.begin(), order_.end(),
            [&](std::size_t a, std::size_t b) { return arrived[a] < arrived[b]; });
}

template <class Value>
std::vector<Value> NumberedRows::exchange(std::span<const Value> own, std::size_t width) const {
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

template <class Value>
std::vector<Value> NumberedRows::gather(std::vector<Value> own, int width) const {
  if (num_ranks(comm_) == 1) return own;
  const auto columns = static_cast<std::size_t>(width);
  const std::vector<Value> arrived = exchange<Value>(own, columns);
  own = {};
  std::vector<Value> rows;
  rows.reserve(arrived.size());
  for (const std::size_t p : order_) {
    const Value* const row = arrived.data() + p * columns;
    rows.insert(rows.end(), row, row + columns);
  }
  return rows;
}

std::vector<double> NumberedRows::gather_rows(std::vector<double> own, int width) const {
  return gather(std::move(own), width);
}

std::vector<std::int32_t> NumberedRows::gather_rows(std::vector<std::int32_t> own,
                                                    int width) const {
  return gather(std::move(own), width);
}

}  // namespace gabion
