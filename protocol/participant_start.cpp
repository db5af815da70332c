// SPDX-License-Identifier: BSD-3-Clause
// How a participant with a time loop of its own says, or is told, where interfaces begin.
#include <algorithm>

#include "common/base/require.hpp"
#include "protocol/participant.hpp"
#include "protocol/wire/exchange.hpp"

namespace gabion {

void Participant::set_start_displacement(const std::string& interface,
                                         std::span<const double> values) {
  before_initialize("set_start_displacement");
  require<UsageError>(settings_.sends == displacement(),
                      "set_start_displacement: found a participant that sends {}, allowed: one "
                      "that sends displacement",
                      settings_.sends.name);
  const std::size_t expected = num_values(interface);
  require<UsageError>(values.size() == expected,
                      "set_start_displacement: found {} values for \"{}\", allowed: {}",
                      values.size(), interface, expected);
  start_.erase(interface);
  if (std::ranges::all_of(values, [](double value) { return value == 0; })) return;
  start_[interface].assign(values.begin(), values.end());
}

void Participant::on_set_start(std::function<void(const InterfaceValues&)> take) {
  before_initialize("on_set_start");
  require<UsageError>(
      settings_.receives == displacement(),
      "on_set_start: found a participant that receives {}, allowed: one that receives "
      "displacement",
      settings_.receives.name);
  require<UsageError>(take != nullptr,
                      "on_set_start: found an empty function, allowed: one that is not");
  take_start_ = std::move(take);
}

/// The call comes before the first step.
Participant::Answer Participant::set_start(const InterfaceValues& displacements) {
  if (!take_start_) machine_->refuse("set_start");
  take_start_(displacements);
  accepted_probes_ = probes_;
  must_write_ = true;  // a state that the code may have saved began at the reference
  return start_set(probes_);
}

}  // namespace gabion
