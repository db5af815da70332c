// SPDX-License-Identifier: BSD-3-Clause
#include "coupler/step/contact_watch.hpp"

namespace gabion {

namespace {
Json signature(const StepReport& report) {
  return report.details.value("contact_signature", Json());
}
}  // namespace

bool ContactWatch::changed(const std::vector<StepReport>& reports) const {
  if (!known_) return false;
  for (std::size_t i = 0; i < reports.size(); ++i) {
    if (reports[i].interface_active != active_[i]) return true;
    if (signature(reports[i]) != signatures_[i]) return true;
  }
  return false;
}

void ContactWatch::accept(const std::vector<StepReport>& reports) {
  known_ = true;
  active_.clear();
  signatures_.clear();
  for (const StepReport& report : reports) {
    active_.push_back(report.interface_active);
    signatures_.push_back(signature(report));
  }
}

void ContactWatch::visit_state(StateVisitor& visitor) {
  Json active = active_, signatures = signatures_;
  visitor.flag("contact.known", known_);
  visitor.fact("contact.active", active);
  visitor.fact("contact.signatures", signatures);
  active_ = active.get<std::vector<bool>>();
  signatures_ = signatures.get<std::vector<Json>>();
}

}  // namespace gabion
