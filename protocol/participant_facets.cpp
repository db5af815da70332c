// SPDX-License-Identifier: BSD-3-Clause
// How a participant with a time loop of its own says, or is told, that interfaces get other facets.
#include "common/base/require.hpp"
#include "protocol/participant.hpp"

namespace gabion {

void Participant::set_facets_may_change(const std::string& interface) {
  before_initialize("set_facets_may_change");
  require<UsageError>(settings_.sends == displacement(),
                      "set_facets_may_change: found a participant that sends {}, allowed: one that "
                      "sends displacement",
                      settings_.sends.name);
  facets_.let_change(mesh(interface));
}

void Participant::write_facets(const std::string& interface, std::span<const std::int64_t> facets) {
  facets_.write(mesh(interface), facets, pending_ && window_complete_);
}

void Participant::on_set_facets(std::function<void(const InterfaceFacets&)> take) {
  before_initialize("on_set_facets");
  require<UsageError>(settings_.receives == displacement(),
                      "on_set_facets: found a participant that receives {}, allowed: one that "
                      "receives displacement",
                      settings_.receives.name);
  require<UsageError>(take != nullptr,
                      "on_set_facets: found an empty function, allowed: one that is not");
  take_facets_ = std::move(take);
}

/// The call comes between two steps, when the code's current state is the accepted one.
Participant::Answer Participant::set_facets(const InterfaceFacets& facets) {
  if (!take_facets_) machine_->refuse("set_facets");
  take_facets_(facets);
  must_write_ = true;  // a state that the code may have saved has the facets before
  return new_message("facets_set");
}

}  // namespace gabion
