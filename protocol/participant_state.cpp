// SPDX-License-Identifier: BSD-3-Clause
// How a participant with a time loop of its own saves and loads its state.
#include "common/base/require.hpp"
#include "protocol/participant.hpp"
#include "protocol/wire/exchange.hpp"

namespace gabion {

void Participant::set_state(std::function<std::vector<std::byte>()> save,
                            std::function<void(std::span<const std::byte>)> load) {
  before_initialize("set_state");
  require<UsageError>(save && load,
                      "set_state: found an empty function, allowed: two that are not");
  save_ = std::move(save);
  load_ = std::move(load);
}

/// The call comes between two steps, when the code's current state is the accepted one.
Participant::Answer Participant::save_state(const std::string&) {
  if (!save_) machine_->refuse("save");
  return saved(pack_bytes(save_()));
}

Participant::Answer Participant::load_state(const Message& request) {
  if (!load_) machine_->refuse("load");
  facets_.while_loading([&] { load_(unpack_bytes(read_state(request))); });
  accepted_probes_ = probes_;
  must_write_ = true;  // the state that the code saved for repeated steps is another one
  return loaded(probes_);
}

}  // namespace gabion
