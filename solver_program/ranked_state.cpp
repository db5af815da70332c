// SPDX-License-Identifier: BSD-3-Clause
#include "solver_program/ranked_state.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <map>
#include <utility>

#include "common/base/require.hpp"
#include "common/mechanics/ranks/gather.hpp"

namespace gabion {

namespace {

using Bytes = std::vector<std::uint8_t>;

template <class Value>
std::vector<Value> scatter(MPI_Comm comm, const std::vector<Value>& all,
                           const std::vector<int>& counts) {
  const std::vector<int> starts = starts_of(counts);
  std::vector<Value> own(counts[rank_of(comm)]);
  MPI_Scatterv(all.data(), counts.data(), starts.data(), mpi_type<Value>(), own.data(),
               static_cast<int>(own.size()), mpi_type<Value>(), 0, comm);
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

/// Why the counts of the ranks do not fit these arrays; empty: they do.
template <class Value>
std::string problem_with(const Json& counts_by_name, std::size_t num_ranks,
                         const std::map<std::string, std::vector<Value>>& arrays) {
  if (!counts_by_name.is_object()) return "found no counts by array";
  for (const auto& [name, counts] : counts_by_name.items()) {
    const auto array = arrays.find(name);
    if (array == arrays.end()) return fmt::format("\"{}\" is missing", name);
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
    if (sum != std::ssize(array->second)) {
      return fmt::format("\"{}\" has {} values, its ranks had {}", name, array->second.size(), sum);
    }
  }
  return "";
}

/// Why this is not what gather_state() made; empty: it is.
std::string problem_with(const State& all) {
  const Json ranks = all.facts.value("ranks", Json());
  if (!ranks.is_number_integer() || ranks < 1 || ranks > std::numeric_limits<int>::max()) {
    return "found no number of MPI ranks";
  }
  const auto num_ranks = ranks.get<std::size_t>();
  const Json facts = all.facts.value("facts", Json());
  const bool each =
      facts.is_array() && facts.size() == num_ranks &&
      std::all_of(facts.begin(), facts.end(), [](const Json& of) { return of.is_object(); });
  if (!each) return fmt::format("found no facts of each of {} ranks", num_ranks);
  const std::string problem = problem_with(all.facts.value("reals", Json()), num_ranks, all.reals);
  return !problem.empty()
             ? problem
             : problem_with(all.facts.value("integers", Json()), num_ranks, all.integers);
}

/// The facts of a gathered state, on all ranks.
Json checked_facts(MPI_Comm comm, const State& all) {
  const std::string problem = rank_of(comm) == 0 ? problem_with(all) : "";
  Json facts = broadcast(comm, problem.empty() ? all.facts : Json(problem));
  if (facts.is_string()) throw Error("saved state: " + facts.get<std::string>());
  return facts;
}

/// The values of each rank, from those of all.
template <class Value>
void split(const Json& counts_by_name, const std::map<std::string, std::vector<Value>>& all,
           std::vector<State>& states, std::map<std::string, std::vector<Value>> State::*values) {
  for (const auto& [name, counts] : counts_by_name.items()) {
    auto next = all.at(name).begin();
    for (std::size_t r = 0; r < states.size(); ++r) {
      const auto end = next + counts.at(r).template get<std::ptrdiff_t>();
      (states[r].*values)[name].assign(next, end);
      next = end;
    }
  }
}

/// The first of these states from the first rank to the others, which have none.
template <class Value>
void broadcast_first(MPI_Comm comm, const Json& counts_by_name, State& state,
                     std::map<std::string, std::vector<Value>> State::*values) {
  for (const auto& [name, counts] : counts_by_name.items()) {
    std::vector<Value>& own = (state.*values)[name];
    own.resize(counts.at(0).template get<std::size_t>());
    MPI_Bcast(own.data(), static_cast<int>(own.size()), mpi_type<Value>(), 0, comm);
  }
}

}  // namespace

State gather_state(MPI_Comm comm, State own) {
  // What has arrived is given up, so that no array is there twice.
  const auto collect = [comm]<class Value>(std::vector<Value> values, std::vector<int>& counts) {
    if (num_ranks(comm) > 1) return gather<Value>(comm, values, counts);
    counts = {static_cast<int>(values.size())};
    return values;
  };
  State all;
  Json real_counts = Json::object(), integer_counts = Json::object(), facts = Json::array();
  std::vector<int> counts;
  for (auto& [name, values] : own.reals) {
    all.reals[name] = collect(std::exchange(values, {}), counts);
    real_counts[name] = counts;
  }
  for (auto& [name, values] : own.integers) {
    all.integers[name] = collect(std::exchange(values, {}), counts);
    integer_counts[name] = counts;
  }
  const Bytes texts = gather<std::uint8_t>(comm, Json::to_cbor(own.facts), counts);
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
  const Json parts = checked_facts(comm, all);
  const int saved_ranks = parts.at("ranks").get<int>();
  require<ConfigError>(
      saved_ranks == num_ranks(comm),
      "restart: found {} MPI ranks, allowed: {}, as in the run that is continued (sums "
      "over other ranks have other last bits)",
      num_ranks(comm), saved_ranks);
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

void load_gathered(MPI_Comm comm, const State& all, Solver& solver) {
  const Json facts = checked_facts(comm, all);
  if (facts.at("ranks") == num_ranks(comm) || !solver.joins_states()) {
    solver.load_state(scatter_state(comm, all));
    return;
  }
  std::vector<State> states(1);
  if (rank_of(comm) == 0) {
    states.resize(facts.at("ranks").get<std::size_t>());
    split(facts.at("reals"), all.reals, states, &State::reals);
    split(facts.at("integers"), all.integers, states, &State::integers);
  }
  for (std::size_t r = 0; r < states.size(); ++r) states[r].facts = facts.at("facts").at(r);
  broadcast_first(comm, facts.at("reals"), states.front(), &State::reals);
  broadcast_first(comm, facts.at("integers"), states.front(), &State::integers);
  solver.join_states(states);
}

}  // namespace gabion
