// SPDX-License-Identifier: BSD-3-Clause
// When secants are worthless because contact changed; before and after a restart.
#include <gtest/gtest.h>

#include "coupler/step/contact_watch.hpp"

namespace gabion::test_contact_watch {
namespace {

StepReport report(bool active, const Json& signature = Json()) {
  StepReport out;
  out.interface_active = active;
  if (!signature.is_null()) out.details["contact_signature"] = signature;
  return out;
}

/// A watch that was saved as text, as a checkpoint has it, and loaded.
ContactWatch restarted(ContactWatch watch) {
  State state;
  StateWriter writer(state);
  watch.visit_state(writer);
  state.facts = Json::parse(state.facts.dump());
  ContactWatch loaded;
  StateReader reader(state);
  loaded.visit_state(reader);
  return loaded;
}

TEST(ContactWatch, a_first_step_changes_nothing) {
  EXPECT_FALSE(ContactWatch().changed({report(true)}));
  EXPECT_FALSE(restarted(ContactWatch()).changed({report(true)}));
}

TEST(ContactWatch, begin_end_and_signature_of_any_soil_are_seen) {
  ContactWatch watch;
  watch.accept({report(true, 5), report(false)});
  for (const ContactWatch& each : {watch, restarted(watch)}) {
    EXPECT_FALSE(each.changed({report(true, 5), report(false)}));
    EXPECT_TRUE(each.changed({report(false, 5), report(false)}));
    EXPECT_TRUE(each.changed({report(true, 5), report(true)}));
    EXPECT_TRUE(each.changed({report(true, 6), report(false)}));
    EXPECT_TRUE(each.changed({report(true), report(false)}));
    EXPECT_TRUE(each.changed({report(true, 5), report(false, 0)}));
  }
}

}  // namespace
}  // namespace gabion::test_contact_watch
