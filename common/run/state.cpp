// SPDX-License-Identifier: BSD-3-Clause
#include "common/run/state.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <utility>

#include "common/base/require.hpp"
#include "common/run/list_lengths.hpp"

namespace gabion {

namespace {

template <class Value>
const std::vector<Value>& entry(const std::map<std::string, std::vector<Value>>& entries,
                                const std::string& name) {
  const auto found = entries.find(name);
  require(found != entries.end(), "saved state: \"{}\" is missing", name);
  return found->second;
}

template <class Value>
void take(const std::map<std::string, std::vector<Value>>& entries, const std::string& name,
          std::span<Value> values) {
  const auto& saved = entry(entries, name);
  require(saved.size() == values.size(), "saved state: \"{}\" has {} values, expected {}", name,
          saved.size(), values.size());
  std::copy(saved.begin(), saved.end(), values.begin());
}

template <class Narrow>
Narrow narrowed(const std::string& name, std::int64_t value) {
  require(std::in_range<Narrow>(value), "saved state: \"{}\" is {}, allowed: {} to {}", name, value,
          std::numeric_limits<Narrow>::min(), std::numeric_limits<Narrow>::max());
  return static_cast<Narrow>(value);
}

}  // namespace

void StateVisitor::integer(const std::string& name, int& value) {
  std::int64_t wide = value;
  integer(name, wide);
  value = narrowed<int>(name, wide);
}

void StateVisitor::flag(const std::string& name, bool& value) {
  std::int64_t wide = value ? 1 : 0;
  integer(name, wide);
  value = wide != 0;
}

void StateVisitor::integers(const std::string& name, std::span<std::int32_t> values) {
  std::vector<std::int64_t> wide(values.begin(), values.end());
  integers(name, std::span<std::int64_t>(wide));
  std::transform(wide.begin(), wide.end(), values.begin(),
                 [&](std::int64_t value) { return narrowed<std::int32_t>(name, value); });
}

void require_values_each(const std::string& name, std::size_t num_values, std::size_t count,
                         std::size_t each) {
  require(num_values % each == 0 && num_values / each == count,
          "saved state: \"{}\" has {} values for {}, expected {} each", name, num_values, count,
          each);
}

StateWriter::StateWriter(State& state, std::string prefix)
    : state_(state), prefix_(std::move(prefix)) {}

void StateWriter::reals(const std::string& name, std::span<double> values) {
  state_.reals[prefix_ + name].assign(values.begin(), values.end());
}

void StateWriter::integers(const std::string& name, std::span<std::int64_t> values) {
  state_.integers[prefix_ + name].assign(values.begin(), values.end());
}

void StateWriter::list(const std::string& name, std::vector<double>& values) {
  state_.lists.insert(prefix_ + name);
  state_.reals[prefix_ + name] = values;
}

void StateWriter::list(const std::string& name, std::vector<std::int64_t>& values) {
  state_.lists.insert(prefix_ + name);
  state_.integers[prefix_ + name] = values;
}

void StateWriter::fact(const std::string& name, Json& value) {
  state_.facts[prefix_ + name] = value;
}

StateReader::StateReader(const State& state, std::string prefix)
    : state_(state), prefix_(std::move(prefix)) {}

void StateReader::reals(const std::string& name, std::span<double> values) {
  take(state_.reals, prefix_ + name, values);
}

void StateReader::integers(const std::string& name, std::span<std::int64_t> values) {
  take(state_.integers, prefix_ + name, values);
}

void StateReader::list(const std::string& name, std::vector<double>& values) {
  values = entry(state_.reals, prefix_ + name);
}

void StateReader::list(const std::string& name, std::vector<std::int64_t>& values) {
  values = entry(state_.integers, prefix_ + name);
}

void StateReader::fact(const std::string& name, Json& value) {
  require(state_.facts.contains(prefix_ + name), "saved state: \"{}\" is missing", prefix_ + name);
  value = state_.facts.at(prefix_ + name);
}

StateJoiner::StateJoiner(const State& first, std::span<const State> own)
    : first_(first), own_(own) {}

void StateJoiner::reals(const std::string& name, std::span<double> values) {
  take(first_.reals, name, values);
}

void StateJoiner::integers(const std::string& name, std::span<std::int64_t> values) {
  take(first_.integers, name, values);
}

void StateJoiner::list(const std::string& name, std::vector<double>& values) {
  values.clear();
  for (const State& state : own_) {
    const auto& part = entry(state.reals, name);
    values.insert(values.end(), part.begin(), part.end());
  }
}

void StateJoiner::list(const std::string& name, std::vector<std::int64_t>& values) {
  values.clear();
  for (const State& state : own_) {
    const auto& part = entry(state.integers, name);
    values.insert(values.end(), part.begin(), part.end());
  }
}

void StateJoiner::fact(const std::string& name, Json& value) {
  StateReader(first_).fact(name, value);
}

void StateJoiner::share(const std::string& name, double& value) {
  value = 0;
  for (const State& state : own_) {
    double part = 0;
    take(state.reals, name, std::span<double>(&part, 1));
    value += part;
  }
}

}  // namespace gabion
