// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "common/settings/config_reader.hpp"

namespace gabion {

/// Share of the forces that their own rounding may leave in |r|: some thousand terms of either
/// sign.
inline constexpr double likely_round_off = 1e-13;

/// A full Newton step below this share of the increment scale cannot improve the solution: what is
/// left of r is round-off (forces that cancel, as in a free body that moves without strain).
inline constexpr double increment_round_off = 1e-14;

/// The "newton" object of a solver's config.
struct NewtonSettings {
  double residual_tolerance = 1e-8;   ///< |r| <= tol * scale of the forces; [eps, 0.1]
  double increment_tolerance = 1e-8;  ///< largest increment of a node <= tol * scale; (0, 1]
  int max_iterations = 20;            ///< >= 1
  /// Keep the matrix (and its factor) while |r| falls by more than a factor 4 an iteration.
  bool reuse_matrix = false;
};
KeyTable newton_keys(const NewtonSettings& defaults = {});
NewtonSettings read_newton_settings(ConfigReader in);

}  // namespace gabion
