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
    case FailureReason::crushing_strain:
      return fmt::format("crushing strain {:.4g} over {:.4g}", value, limit);
    case FailureReason::none:
      break;
  }
  return "none";
}

namespace {

const std::vector<std::string> lines_along = {"truss", "cable", "brake", "bar"};

/// @param lines  with those of lines
Key strain_key(bool lines) {
  std::vector<std::string> laws = {"concrete"};
  if (lines) laws.insert(laws.end(), lines_along.begin(), lines_along.end());
  const std::string of_line =
      "a line breaks, from its length without stress and without the run of its brake; or ";
  return key::number("failure_strain", "",
                     "Strain beyond which " + (lines ? of_line : "") +
                         "a cell of concrete fails and leaves the structure: the width of its "
                         "crack over that of its band, mean of its points, in an accepted step.")
      .in(positive())
      .or_none()
      .when("law", laws);
}

Key crushing_strain_key() {
  return key::number("failure_crushing_strain", "",
                     "Compressive strain, positive, beyond which a cell of concrete fails and "
                     "leaves the structure: the strain at which a bar is crushed as far, mean of "
                     "its points, in an accepted step. Above `strain_at_strength`.")
      .in(positive())
      .or_none()
      .when("law", {"concrete"});
}

}  // namespace

std::vector<Key> failure_keys(bool lines) {
  std::vector<std::string> yielding = {"von_mises"}, failing = {"von_mises", "concrete"};
  if (lines) {
    yielding.insert(yielding.end(), {"bar", "beam"});
    failing.insert(failing.end(), lines_along.begin(), lines_along.end());
    failing.emplace_back("beam");
  }
  std::vector<Key> keys = {
      key::number("failure_plastic_strain", "",
                  "Plastic strain beyond which a cell fails and leaves the structure: that of one "
                  "of its points, in a beam of one of its fibres, in an accepted step.")
          .in(positive())
          .or_none()
          .when("law", yielding),
      key::integer("fade_steps",
                   "Number of steps, as long as the one in which a cell fails, over which its "
                   "stress falls to zero; in dynamics at least the time in which a wave crosses "
                   "the cell. Only with a limit of failure; 3 where it is not given.")
          .in(at_least(1))
          .or_none()
          .when("law", failing)};
  if (lines) {
    keys.push_back(key::number("failure_force", "N", "Tension beyond which a line breaks.")
                       .in(positive())
                       .or_none()
                       .when("law", lines_along));
  }
  keys.push_back(strain_key(lines));
  keys.push_back(crushing_strain_key());
  return keys;
}

FailureLimits read_failure(ConfigReader& in, const std::string& law) {
  const auto is = [&](std::initializer_list<std::string_view> laws) {
    return std::ranges::find(laws, law) != laws.end();
  };
  const bool yields = is({"von_mises", "bar", "beam"});
  const bool along = is({"truss", "cable", "brake", "bar"}), cracks = is({"concrete"});
  if (!yields && !along && !cracks) return {};
  const auto read = [&](bool has_it, const char* key) {
    return has_it && in.has(key) ? std::optional<double>(in.number(key)) : std::nullopt;
  };
  FailureLimits limits{.plastic_strain = read(yields, "failure_plastic_strain"),
                       .force = read(along, "failure_force"),
                       .strain = read(along || cracks, "failure_strain"),
                       .crushing_strain = read(cracks, "failure_crushing_strain")};
  if (in.has("fade_steps") && !limits.any()) {
    in.fail("fade_steps", "found without a limit of failure, allowed: with \"failure_...\"");
  }
  if (in.has("fade_steps")) limits.fade_steps = in.integer("fade_steps");
  return limits;
}

}  // namespace gabion::fem
