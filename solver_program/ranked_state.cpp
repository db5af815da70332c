// SPDX-License-Identifier: BSD-3-Clause
#include "solver_program/ranked_state.hpp"

#include <algorithm>
#include <map>
#include <utility>

#include "common/base/require.hpp"
#include "common/mechanics/ranks/gather.hpp"
#include "common/mechanics/ranks/text.hpp"
#include "solver_program/ranked_parts.hpp"

namespace gabion {

namespace {

template <class Value>
std::vector<Value> scatter(MPI_Comm comm, const std::vector<Value>& all,
                           const std::vector<int>& counts) {
  const std::vector<int> starts = starts_of(counts);
  std::vector<Value> own(counts[rank_of(comm)]);
  MPI_Scatterv(all.data(), counts.data(), starts.data(), mpi_type<Value>(), own.data(),
               static_cast<int>(own.size()), mpi_type<Value>(), 0, comm);
  return own;
}

/// Layout of the parts in a gathered state, checked, on all ranks.
Json checked_parts(MPI_Comm comm, const State& all) {
  together(comm, [&] {
    if (rank_of(comm) != 0) return;
    check_parts(all.facts, [&](const std::string& kind, const std::string& name) -> std::int64_t {
      const auto size_in = [&](const auto& arrays) {
        const auto array = arrays.find(name);
        return array == arrays.end() ? -1 : std::ssize(array->second);
      };
      return kind == "reals" ? size_in(all.reals) : size_in(all.integers);
    });
  });
  return broadcast(comm, all.facts);
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

/// The first of these states but for its lists, from the first rank to the others.
template <class Value>
void broadcast_first(MPI_Comm comm, const Json& parts, const Json& counts_by_name,
                     std::map<std::string, std::vector<Value>>& arrays) {
  const auto lists = parts.value("lists", std::vector<std::string>());
  for (const auto& [name, counts] : counts_by_name.items()) {
    if (std::ranges::find(lists, name) != lists.end()) continue;
    std::vector<Value>& own = arrays[name];
    own.resize(counts.at(0).template get<std::size_t>());
    MPI_Bcast(own.data(), static_cast<int>(own.size()), mpi_type<Value>(), 0, comm);
  }
}

}  // namespace

void require_ranks(MPI_Comm comm, int saved_ranks) {
  require<ConfigError>(
      saved_ranks == num_ranks(comm),
      "restart: found {} MPI ranks, allowed: {}, as in the run that is continued (sums "
      "over other ranks have other last bits)",
      num_ranks(comm), saved_ranks);
}

State gather_state(MPI_Comm comm, State own) {
  State all;
  all.facts = gather_parts(comm, own);
  // Arrays that have arrived are released, so that none is there twice.
  const auto collect = [comm]<class Value>(std::vector<Value> values) {
    return num_ranks(comm) > 1 ? gather<Value>(comm, values) : std::move(values);
  };
  for (auto& [name, values] : own.reals) all.reals[name] = collect(std::exchange(values, {}));
  for (auto& [name, values] : own.integers) {
    all.integers[name] = collect(std::exchange(values, {}));
  }
  return rank_of(comm) == 0 ? std::move(all) : State();
}

State scatter_state(MPI_Comm comm, const State& all) {
  const Json parts = checked_parts(comm, all);
  const int saved_ranks = parts.at("ranks").get<int>();
  require_ranks(comm, saved_ranks);
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
  const Json parts = checked_parts(comm, all);
  if (parts.at("ranks") == num_ranks(comm) || !solver.joins_states()) {
    solver.load_state(scatter_state(comm, all));
    return;
  }
  std::vector<State> states;
  if (rank_of(comm) == 0) {
    states.resize(parts.at("ranks").get<std::size_t>());
    split(parts.at("reals"), all.reals, states, &State::reals);
    split(parts.at("integers"), all.integers, states, &State::integers);
    for (std::size_t r = 0; r < states.size(); ++r) states[r].facts = parts.at("facts").at(r);
  }
  State other_first;
  other_first.facts = parts.at("facts").at(0);
  State& first = states.empty() ? other_first : states.front();
  broadcast_first(comm, parts, parts.at("reals"), first.reals);
  broadcast_first(comm, parts, parts.at("integers"), first.integers);
  solver.join_states(first, states);
}

}  // namespace gabion
