// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cstdint>
#include <string>

#include "common/settings/config_reader.hpp"

namespace gabion {

/// Part of a step that is skipped without contact: the acceleration, and the solution of a
/// structure at rest.
enum class Skipped { nothing, acceleration, structure };
std::string name(Skipped skipped);

/// Counts of a coupled run for summary.json.
struct CouplingCounts {
  std::int64_t steps = 0;     ///< accepted
  std::int64_t total = 0;     ///< iterations that were completed, those of rejected steps too
  std::int64_t accepted = 0;  ///< iterations of accepted steps
  std::int64_t steps_in_contact = 0;
  std::int64_t accepted_in_contact = 0;
  int max = 0;                            ///< iterations of one accepted solution
  std::int64_t skipped_acceleration = 0;  ///< steps done in one pass for lack of contact
  std::int64_t skipped_structure = 0;     ///< steps among these that did not solve a structure
  std::int64_t accepted_unconverged = 0;
  std::int64_t history_resets =
      0;  ///< of quasi-Newton columns: contact had changed, or dt had fallen
  std::int64_t filter_fallbacks = 0;  ///< to the default filter, because the chosen one made no
                                      ///< progress
  std::int64_t started_early = 0;     ///< steps that soils began before they had accepted the last
  std::int64_t called_off = 0;        ///< steps among these that were then asked for differently

  void add_step(int iterations, Skipped skipped) {
    ++steps;
    accepted += iterations;
    max = std::max(max, iterations);
    if (skipped == Skipped::nothing) {
      ++steps_in_contact;
      accepted_in_contact += iterations;
    } else {
      ++skipped_acceleration;
    }
    if (skipped == Skipped::structure) ++skipped_structure;
  }

  Json json() const {
    const auto mean = [](std::int64_t sum, std::int64_t count) {
      return count > 0 ? Json(static_cast<double>(sum) / static_cast<double>(count)) : Json();
    };
    return {{"coupling_iterations",
             {{"total", total},
              {"rejected", total - accepted},
              {"mean", mean(accepted, steps)},
              {"mean_in_contact", mean(accepted_in_contact, steps_in_contact)},
              {"max", max}}},
            {"steps_in_contact", steps_in_contact},
            {"skipped", {{"acceleration", skipped_acceleration}, {"structure", skipped_structure}}},
            {"accepted_unconverged", accepted_unconverged},
            {"history_resets", history_resets},
            {"filter_fallbacks", filter_fallbacks},
            {"started_early", started_early},
            {"called_off", called_off}};
  }
};

}  // namespace gabion
