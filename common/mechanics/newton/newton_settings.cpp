// SPDX-License-Identifier: BSD-3-Clause
#include "common/mechanics/newton/newton_settings.hpp"

#include <limits>

#include "common/base/log.hpp"

namespace gabion {

namespace {

constexpr double epsilon = std::numeric_limits<double>::epsilon();

}  // namespace

KeyTable newton_keys(const NewtonSettings& defaults) {
  return {
      "newton",
      "Newton's method for the displacements of a step.",
      {key::number("residual_tolerance", "",
                   "Residual |r| over the largest of |f_int|, |f_ext|, |f_inertia| (of the soil "
                   "also 1e-3 |m v| / dt); below 1e-13 rounding alone may keep the residual "
                   "larger. From the second coupling iteration on the soil uses a hundredth of "
                   "this tolerance.")
           .in(in_words(between(epsilon, 0.1),
                        "a number from 2.3e-16 (rounding of the forces) to 0.1"))
           .or_else(defaults.residual_tolerance),
       key::number("increment_tolerance", "",
                   "Largest increment of a node over the mean cell size.")
           .in({.low = 0, .high = 1, .low_open = true, .allowed = "a number in (0, 1]"})
           .or_else(defaults.increment_tolerance),
       key::integer("max_iterations", "Number of iterations after which the step has failed.")
           .in(at_least(1))
           .or_else(defaults.max_iterations),
       key::boolean("reuse_matrix",
                    "Whether the matrix and its factors are kept while |r| falls by more than a "
                    "factor of 4 per iteration.")
           .or_else(defaults.reuse_matrix)}};
}

NewtonSettings read_newton_settings(ConfigReader in) {
  NewtonSettings settings;
  settings.residual_tolerance = in.number("residual_tolerance");
  settings.increment_tolerance = in.number("increment_tolerance");
  settings.max_iterations = in.integer("max_iterations");
  settings.reuse_matrix = in.boolean("reuse_matrix");
  in.finish();
  if (settings.residual_tolerance < likely_round_off) {
    log::warn(
        "{}: found {:g}: |r| is a sum of forces that cancel, and their rounding alone may keep it "
        "above that; {:g} is a safe choice",
        in.where("residual_tolerance"), settings.residual_tolerance, likely_round_off);
  }
  if (settings.increment_tolerance < increment_round_off) {
    log::warn("{}: found {:g}: without effect below {:g}, where a step counts as small in any case",
              in.where("increment_tolerance"), settings.increment_tolerance, increment_round_off);
  }
  return settings;
}

}  // namespace gabion
