// SPDX-License-Identifier: BSD-3-Clause
#include "solver_program/ranked_parts.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <vector>

#include "common/base/require.hpp"
#include "common/mechanics/ranks/gather.hpp"

namespace gabion {

namespace {

using Bytes = std::vector<std::uint8_t>;

/// Reason why the counts of the ranks do not fit the arrays of this kind; empty: they do.
std::string problem_with(const Json& parts, const std::string& kind, const ArraySize& size) {
  const Json counts_by_name = parts.value(kind, Json());
  const auto num_ranks = parts.at("ranks").get<std::size_t>();
  if (!counts_by_name.is_object()) return "found no counts by array";
  for (const auto& [name, counts] : counts_by_name.items()) {
    const std::int64_t found = size(kind, name);
    if (found < 0) return fmt::format("\"{}\" is missing", name);
    if (!counts.is_array() || counts.size() != num_ranks) {
      return fmt::format("\"{}\": found counts {}, allowed: one for each of {} ranks", name,
                         counts.dump(), num_ranks);
    }
    std::int64_t sum = 0;
    for (const Json& count : counts) {
      const bool good =
          count.is_number_integer() && count >= 0 && count <= std::numeric_limits<int>::max();
      if (!good) return fmt::format("\"{}\": found count {}", name, count.dump());
      sum += count.get<std::int64_t>();
    }
    if (sum != found) {
      return fmt::format("\"{}\" has {} values, its ranks had {}", name, found, sum);
    }
  }
  return "";
}

std::string problem_with(const Json& parts, const ArraySize& size) {
  const Json ranks = parts.value("ranks", Json());
  if (!ranks.is_number_integer() || ranks < 1 || ranks > std::numeric_limits<int>::max()) {
    return "found no number of MPI ranks";
  }
  const auto num_ranks = ranks.get<std::size_t>();
  const Json facts = parts.value("facts", Json());
  const bool each =
      facts.is_array() && facts.size() == num_ranks &&
      std::all_of(facts.begin(), facts.end(), [](const Json& of) { return of.is_object(); });
  if (!each) return fmt::format("found no facts of each of {} ranks", num_ranks);
  const Json lists = parts.value("lists", Json::array());
  if (!lists.is_array() || !std::ranges::all_of(lists, &Json::is_string)) {
    return "found no names of lists";
  }
  const std::string problem = problem_with(parts, "reals", size);
  return !problem.empty() ? problem : problem_with(parts, "integers", size);
}

}  // namespace

Json gather_parts(MPI_Comm comm, const State& own) {
  std::vector<std::int64_t> sizes;
  for (const auto& entry : own.reals) sizes.push_back(std::ssize(entry.second));
  for (const auto& entry : own.integers) sizes.push_back(std::ssize(entry.second));
  const std::vector<std::int64_t> all_sizes = gather<std::int64_t>(comm, sizes);
  std::vector<int> lengths;
  const Bytes texts = gather<std::uint8_t>(comm, Json::to_cbor(own.facts), lengths);
  if (rank_of(comm) != 0) return nullptr;
  const auto num_ranks = lengths.size();
  Json facts = Json::array();
  const std::vector<int> starts = starts_of(lengths);
  for (std::size_t r = 0; r < num_ranks; ++r) {
    facts.push_back(Json::from_cbor(texts.begin() + starts[r], texts.begin() + starts[r + 1]));
  }
  std::size_t array = 0;
  const auto counts_of = [&](const auto& arrays) {
    Json counts = Json::object();
    for (const auto& [name, values] : arrays) {
      for (std::size_t r = 0; r < num_ranks; ++r) {
        counts[name].push_back(all_sizes[r * sizes.size() + array]);
      }
      ++array;
    }
    return counts;
  };
  Json parts = {{"ranks", num_ranks}, {"facts", facts}, {"lists", own.lists}};
  parts["reals"] = counts_of(own.reals);
  parts["integers"] = counts_of(own.integers);
  return parts;
}

void check_parts(const Json& parts, const ArraySize& size) {
  const std::string problem = problem_with(parts, size);
  require(problem.empty(), "saved state: {}", problem);
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

}  // namespace gabion
