// SPDX-License-Identifier: BSD-3-Clause
#include "solver_program/ranked_state_file.hpp"

#include <algorithm>
#include <optional>
#include <utility>
#include <vector>

#include "common/base/require.hpp"
#include "common/hdf5/hdf5_reader.hpp"
#include "common/mechanics/output/ranked_hdf5_file.hpp"
#include "common/mechanics/ranks/text.hpp"
#include "common/settings/json_text.hpp"
#include "solver_program/ranked_parts.hpp"
#include "solver_program/ranked_state.hpp"

namespace gabion {

namespace {

/// The states in a file.
class RankedStateReader {
 public:
  explicit RankedStateReader(const std::string& path) : file_(path) {
    parts_ = parse_settings(file_.text("facts"), path + ": dataset facts");
    require(parts_.is_object(), "{}: dataset facts is not a JSON object", path);
    const auto reals = file_.names("reals"), integers = file_.names("integers");
    check_parts(parts_, [&](const std::string& kind, const std::string& name) -> std::int64_t {
      const auto& names = kind == "reals" ? reals : integers;
      if (std::ranges::find(names, name) == names.end()) return -1;
      return file_.size(kind + "/" + name);
    });
    lists_ = parts_.value("lists", std::vector<std::string>());
  }

  int num_ranks() const { return parts_.at("ranks").get<int>(); }

  /// State of one rank.
  State state_of(int rank, bool with_lists) const {
    State state;
    state.facts = parts_.at("facts").at(rank);
    for (const std::string kind : {"reals", "integers"}) {
      for (const auto& [name, counts] : parts_.at(kind).items()) {
        if (!with_lists && std::ranges::find(lists_, name) != lists_.end()) continue;
        ValueRange range{.first = 0, .count = counts.at(rank).get<std::int64_t>()};
        for (int r = 0; r < rank; ++r) range.first += counts.at(r).get<std::int64_t>();
        const std::string dataset = kind + "/" + name;
        if (kind == "reals") {
          state.reals[name] = file_.reals(dataset, range);
        } else {
          state.integers[name] = file_.integers(dataset, range);
        }
      }
    }
    return state;
  }

 private:
  Hdf5Reader file_;
  Json parts_;
  std::vector<std::string> lists_;
};

/// Rank that takes the part of a rank of the other run: at most one part each as long as there are
/// enough ranks; the first rank takes the part of the first.
int taker_of(int part, int num_parts, int num_ranks) {
  return static_cast<int>(std::int64_t{part} * num_ranks / num_parts);
}

}  // namespace

void write_ranked_state(MPI_Comm comm, const std::string& path, State own) {
  const Json parts = broadcast(comm, gather_parts(comm, own));
  const auto file = new_array_file(path, comm);
  file->write_text("facts", parts.dump());
  for (auto& [name, values] : own.reals) {
    file->write("reals/" + name, 1, std::span<const double>(values));
    values = {};
  }
  for (auto& [name, values] : own.integers) {
    file->write("integers/" + name, 1, std::span<const std::int64_t>(values));
    values = {};
  }
  file->finish();
}

void load_ranked_state(MPI_Comm comm, const std::string& path, Solver& solver) {
  const int own_rank = rank_of(comm), size = num_ranks(comm);
  std::optional<RankedStateReader> file;
  together(comm, [&] { file.emplace(path); });
  const int num_parts = file->num_ranks();
  const bool joins = num_parts != size && solver.joins_states();
  if (!joins) require_ranks(comm, num_parts);
  std::vector<State> own;
  State other_first;
  together(comm, [&] {
    for (int part = 0; part < num_parts; ++part) {
      if (taker_of(part, num_parts, size) == own_rank) own.push_back(file->state_of(part, true));
    }
    if (joins && own_rank != 0) other_first = file->state_of(0, false);
  });
  file.reset();
  if (joins) {
    solver.join_states(own_rank == 0 ? own.front() : other_first, own);
  } else {
    solver.load_state(own.front());
  }
}

}  // namespace gabion
