// SPDX-License-Identifier: BSD-3-Clause
// How a participant with a time loop of its own saves and loads its state.
#include "common/base/require.hpp"
#include "protocol/exchange.hpp"
#include "protocol/participant.hpp"

namespace gabion {

void Participant::set_state(std::function<std::vector<std::byte>()> save,
                            std::function<void(std::span<const std::byte>)> load) {
  before_initialize("set_state");
  require<UsageError>(save && load,
                      "set_state: found an empty function, allowed: two that are not");
  save_ = std::move(save);
  load_ = std::move(load);
}

/// Between two steps, when the code's current state is the accepted one.
void Participant::save_state() {
  reply(saved(pack_bytes(save_())));
}

void Participant::load_state(const Message& request) {
  load_(unpack_bytes(read_state(request)));
  order_.forget();
  accepted_probes_ = probes_;
  must_write_ = true;  // what the code saved for repeated steps is of another state
  reply(loaded(probes_));
}

}  // namespace gabion
