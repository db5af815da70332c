// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "common/base/json.hpp"

namespace gabion {

/// What later steps of a run depend on, by name. Every bit of a number is kept.
struct State {
  Json facts = Json::object();  ///< texts and lists; finite numbers only
  std::map<std::string, std::vector<double>> reals;
  std::map<std::string, std::vector<std::int64_t>> integers;
};

/// Goes through the parts of an object in a fixed order, to put them into a State or to take them
/// from one: each class lists its parts once, in a function `visit_state(StateVisitor&)`.
class StateVisitor {
 public:
  virtual ~StateVisitor() = default;

  /// As many values as the object has already.
  /// @throws Error  taking: there are none of this name, or another number of them
  virtual void reals(const std::string& name, std::span<double> values) = 0;
  virtual void integers(const std::string& name, std::span<std::int64_t> values) = 0;
  /// A list that may have got any length; on several ranks what this rank has.
  virtual void list(const std::string& name, std::vector<double>& values) = 0;
  virtual void list(const std::string& name, std::vector<std::int64_t>& values) = 0;
  virtual void fact(const std::string& name, Json& value) = 0;

  /// What this rank adds to a sum over the ranks.
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

/// Takes parts from the States of all ranks of a run that goes on with another number of them. One
/// rank gets their lists, one after the other, and the sums of their shares; the others get empty
/// lists and shares of zero. All else is equal on the ranks, and taken from the first State.
class StateJoiner final : public StateVisitor {
 public:
  /// @param gets_all  this rank is the one that gets lists and shares
  StateJoiner(std::span<const State> states, bool gets_all);
  using StateVisitor::integers;
  void reals(const std::string& name, std::span<double> values) override;
  void integers(const std::string& name, std::span<std::int64_t> values) override;
  void list(const std::string& name, std::vector<double>& values) override;
  void list(const std::string& name, std::vector<std::int64_t>& values) override;
  void fact(const std::string& name, Json& value) override;
  void share(const std::string& name, double& value) override;

 private:
  std::span<const State> states_;
  bool gets_all_;
};

}  // namespace gabion
