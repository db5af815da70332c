// SPDX-License-Identifier: BSD-3-Clause
#include "common/mechanics/ranks/ranked_state.hpp"

#include <fmt/format.h>

#include <numeric>

#include "common/base/error.hpp"
#include "common/mechanics/ranks/sum.hpp"

namespace gabion {

namespace {

using Bytes = std::vector<std::uint8_t>;

MPI_Datatype type_of(const std::vector<double>&) {
  return MPI_DOUBLE;
}
MPI_Datatype type_of(const std::vector<std::int64_t>&) {
  return MPI_INT64_T;
}
MPI_Datatype type_of(const Bytes&) {
  return MPI_BYTE;
}

std::vector<int> starts_of(const std::vector<int>& counts) {
  std::vector<int> starts(counts.size() + 1, 0);
  std::partial_sum(counts.begin(), counts.end(), starts.begin() + 1);
  return starts;
}

/// @param[out] counts  values of each rank, on the first one
template <class Value>
std::vector<Value> gather(MPI_Comm comm, const std::vector<Value>& own, std::vector<int>& counts) {
  const int count = static_cast<int>(own.size());
  counts.assign(num_ranks(comm), 0);
  MPI_Gather(&count, 1, MPI_INT, counts.data(), 1, MPI_INT, 0, comm);
  const std::vector<int> starts = starts_of(counts);
  std::vector<Value> all(rank_of(comm) == 0 ? starts.back() : 0);
  MPI_Gatherv(own.data(), count, type_of(own), all.data(), counts.data(), starts.data(),
              type_of(own), 0, comm);
  return all;
}

template <class Value>
std::vector<Value> scatter(MPI_Comm comm, const std::vector<Value>& all,
                           const std::vector<int>& counts) {
  const std::vector<int> starts = starts_of(counts);
  std::vector<Value> own(counts[rank_of(comm)]);
  MPI_Scatterv(all.data(), counts.data(), starts.data(), type_of(all), own.data(),
               static_cast<int>(own.size()), type_of(own), 0, comm);
  return own;
}

Json broadcast(MPI_Comm comm, const Json& value) {
  Bytes bytes;
  if (rank_of(comm) == 0) bytes = Json::to_cbor(value);
  int size = static_cast<int>(bytes.size());
  MPI_Bcast(&size, 1, MPI_INT, 0, comm);
  bytes.resize(size);
  MPI_Bcast(bytes.data(), size, MPI_BYTE, 0, comm);
  return Json::from_cbor(bytes);
}

}  // namespace

State gather_state(MPI_Comm comm, const State& own) {
  State all;
  Json real_counts = Json::object(), integer_counts = Json::object(), facts = Json::array();
  std::vector<int> counts;
  for (const auto& [name, values] : own.reals) {
    all.reals[name] = gather(comm, values, counts);
    real_counts[name] = counts;
  }
  for (const auto& [name, values] : own.integers) {
    all.integers[name] = gather(comm, values, counts);
    integer_counts[name] = counts;
  }
  const Bytes texts = gather(comm, Json::to_cbor(own.facts), counts);
  if (rank_of(comm) != 0) return {};
  const std::vector<int> starts = starts_of(counts);
  for (std::size_t r = 0; r < counts.size(); ++r) {
    facts.push_back(Json::from_cbor(texts.begin() + starts[r], texts.begin() + starts[r + 1]));
  }
  all.facts = {{"ranks", num_ranks(comm)},
               {"facts", facts},
               {"reals", real_counts},
               {"integers", integer_counts}};
  return all;
}

State scatter_state(MPI_Comm comm, const State& all) {
  const Json parts = broadcast(comm, all.facts);
  const int saved_ranks = parts.at("ranks").get<int>();
  require<ConfigError>(
      saved_ranks == num_ranks(comm),
      fmt::format("restart: found {} MPI ranks, allowed: {}, as in the run that is continued (sums "
                  "over other ranks have other last bits)",
                  num_ranks(comm), saved_ranks));
  State own;
  own.facts = parts.at("facts").at(rank_of(comm));
  const bool root = rank_of(comm) == 0;
  for (const auto& [name, counts] : parts.at("reals").items()) {
    own.reals[name] = scatter(comm, root ? all.reals.at(name) : std::vector<double>(),
                              counts.get<std::vector<int>>());
  }
  for (const auto& [name, counts] : parts.at("integers").items()) {
    own.integers[name] = scatter(comm, root ? all.integers.at(name) : std::vector<std::int64_t>(),
                                 counts.get<std::vector<int>>());
  }
  return own;
}

}  // namespace gabion
