// SPDX-License-Identifier: BSD-3-Clause
#include "fem_solver/materials/failure.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <initializer_list>
#include <string_view>

namespace gabion::fem {

std::string describe(FailureReason reason, double value, double limit) {
  switch (reason) {
    case FailureReason::plastic_strain:
      return fmt::format("plastic strain {:.4g} over {:.4g}", value, limit);
    case FailureReason::force:
      return fmt::format("force {:.5g} N over {:.5g} N", value, limit);
    case FailureReason::strain:
      return fmt::format("strain {:.4g} over {:.4g}", value, limit);
    case FailureReason::none:
      break;
  }
  return "none";
}

std::vector<Key> failure_keys(bool lines) {
  std::vector<std::string> yielding = {"von_mises"}, failing = {"von_mises"};
  const std::vector<std::string> along = {"truss", "cable", "brake", "bar"};
  if (lines) {
    yielding.insert(yielding.end(), {"bar", "beam"});
    failing.insert(failing.end(), along.begin(), along.end());
    failing.emplace_back("beam");
  }
  std::vector<Key> keys = {
      key::number("failure_plastic_strain", "",
                  "A cell fails, and leaves the structure, when the plastic strain of one of its "
                  "points, of a beam of one of its fibres, exceeds this in an accepted step.")
          .in(positive())
          .or_none()
          .when("law", yielding),
      key::integer("fade_steps",
                   "Accepted steps, of the size of that in which it fails, over which the stress "
                   "of a failed cell falls to zero, in dynamics no shorter than a wave needs to "
                   "cross it; only with one of the limits of failure, 3 where it is not given.")
          .in(at_least(1))
          .or_none()
          .when("law", failing)};
  if (!lines) return keys;
  keys.push_back(key::number("failure_force", "N", "A line breaks when its tension exceeds this.")
                     .in(positive())
                     .or_none()
                     .when("law", along));
  keys.push_back(key::number("failure_strain", "",
                             "A line breaks when its strain from the length without stress, less "
                             "the run of its brake, exceeds this.")
                     .in(positive())
                     .or_none()
                     .when("law", along));
  return keys;
}

FailureLimits read_failure(ConfigReader& in, const std::string& law) {
  const auto is = [&](std::initializer_list<std::string_view> laws) {
    return std::ranges::find(laws, law) != laws.end();
  };
  const bool yields = is({"von_mises", "bar", "beam"});
  const bool along = is({"truss", "cable", "brake", "bar"});
  if (!yields && !along) return {};
  const auto read = [&](bool has_it, const char* key) {
    return has_it && in.has(key) ? std::optional<double>(in.number(key)) : std::nullopt;
  };
  FailureLimits limits{.plastic_strain = read(yields, "failure_plastic_strain"),
                       .force = read(along, "failure_force"),
                       .strain = read(along, "failure_strain")};
  if (in.has("fade_steps") && !limits.any()) {
    in.fail("fade_steps", "found without a limit of failure, allowed: with \"failure_...\"");
  }
  if (in.has("fade_steps")) limits.fade_steps = in.integer("fade_steps");
  return limits;
}

}  // namespace gabion::fem
