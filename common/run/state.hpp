// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "common/base/json.hpp"

namespace gabion {

/// Values that later steps of a run depend on, by name. Every bit of a number is kept.
struct State {
  Json facts = Json::object();  ///< texts and lists; finite numbers only
  std::map<std::string, std::vector<double>> reals;
  std::map<std::string, std::vector<std::int64_t>> integers;
  std::set<std::string> lists;  ///< arrays that have any length, another one on each rank
  /// File with the whole state, which the solver wrote itself (Solver::save_state_to); empty where
  /// the state is in the members above.
  std::string file;
};

/// Goes through the parts of an object in a fixed order, to put them into a State or to take them
/// from one: each class lists its parts once, in a function `visit_state(StateVisitor&)`.
class StateVisitor {
 public:
  virtual ~StateVisitor() = default;

  /// Visits as many values as the object has already.
  /// @throws Error  taking: there are none of this name, or another number of them
  virtual void reals(const std::string& name, std::span<double> values) = 0;
  virtual void integers(const std::string& name, std::span<std::int64_t> values) = 0;
  /// A list that may have got any length; on several ranks what this rank has.
  virtual void list(const std::string& name, std::vector<double>& values) = 0;
  virtual void list(const std::string& name, std::vector<std::int64_t>& values) = 0;
  virtual void fact(const std::string& name, Json& value) = 0;

  /// This rank's part of a sum over the ranks.
  virtual void share(const std::string& name, double& value) { real(name, value); }

  void real(const std::string& name, double& value) { reals(name, {&value, 1}); }
  void integer(const std::string& name, std::int64_t& value) { integers(name, {&value, 1}); }
  void integer(const std::string& name, int& value);
  void flag(const std::string& name, bool& value);
  void integers(const std::string& name, std::span<std::int32_t> values);
};

/// Puts parts into a State. Names begin with `prefix`.
class StateWriter final : public StateVisitor {
 public:
  explicit StateWriter(State& state, std::string prefix = "");
  using StateVisitor::integers;
  void reals(const std::string& name, std::span<double> values) override;
  void integers(const std::string& name, std::span<std::int64_t> values) override;
  void list(const std::string& name, std::vector<double>& values) override;
  void list(const std::string& name, std::vector<std::int64_t>& values) override;
  void fact(const std::string& name, Json& value) override;

 private:
  State& state_;
  std::string prefix_;
};

/// Takes parts from a State. Names begin with `prefix`.
class StateReader final : public StateVisitor {
 public:
  explicit StateReader(const State& state, std::string prefix = "");
  using StateVisitor::integers;
  void reals(const std::string& name, std::span<double> values) override;
  void integers(const std::string& name, std::span<std::int64_t> values) override;
  void list(const std::string& name, std::vector<double>& values) override;
  void list(const std::string& name, std::vector<std::int64_t>& values) override;
  void fact(const std::string& name, Json& value) override;

 private:
  const State& state_;
  std::string prefix_;
};

/// Takes parts from the States of another number of ranks, each of which one rank has here: the
/// lists of these, one after the other, and the sums of their shares; nothing and zero where a rank
/// has none. All else is equal on the ranks of a run.
class StateJoiner final : public StateVisitor {
 public:
  /// @param first  of the first rank of the other run: what is equal on all of them
  /// @param own    those that this rank has
  StateJoiner(const State& first, std::span<const State> own);
  using StateVisitor::integers;
  void reals(const std::string& name, std::span<double> values) override;
  void integers(const std::string& name, std::span<std::int64_t> values) override;
  void list(const std::string& name, std::vector<double>& values) override;
  void list(const std::string& name, std::vector<std::int64_t>& values) override;
  void fact(const std::string& name, Json& value) override;
  void share(const std::string& name, double& value) override;

 private:
  const State& first_;
  std::span<const State> own_;
};

}  // namespace gabion
