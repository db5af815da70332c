// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "common/mechanics/time_integration/newmark.hpp"
#include "common/settings/config_reader.hpp"
#include "mpm_solver/phases/load_ramp.hpp"
#include "mpm_solver/phases/strength_reduction.hpp"
#include "mpm_solver/walls/wall_conditions.hpp"

namespace gabion::mpm {

/// Treatment of a material point that leaves the background grid.
enum class Outside { error, remove };

/// A facet group of the grid through which soil leaves: nothing supports it there, and material
/// points that pass it are taken out.
struct OutflowSide {
  std::string group;
  std::string where;  ///< file and pointer, for messages
};

/// A part of the run with its own kind of analysis and its own walls. Which phase a step belongs to
/// follows from the time at which it starts and from nothing else.
struct Phase {
  double start = 0;                                        ///< [s]
  double until = std::numeric_limits<double>::infinity();  ///< [s], end of the phase
  double dt = 0;        ///< [s] largest step of the phase; 0: whatever the owner of time says
  bool dynamic = true;  ///< false: quasi-static, inertia is left out
  NewmarkBossak scheme = NewmarkBossak::bossak(-0.1);
  /// Explicit: largest substep by the stable one (StableStep). Not set: implicit, by `scheme`.
  std::optional<double> courant;
  std::vector<WallSettings> walls;
  std::vector<OutflowSide> outflows;
  /// Names of the rigid walls that act. read_phases() leaves it empty where a phase does not name
  /// them; resolve_rigid_walls() fills it.
  std::optional<std::vector<std::string>> rigid_walls;
  LoadRamp gravity_ramp;
  /// Search for the factor of safety, in quasi-static phases; not set: full strength.
  std::optional<StrengthReduction> strength_reduction;

  bool is_explicit() const { return dynamic && courant.has_value(); }
};

bool any_implicit(const std::vector<Phase>& phases);
bool any_explicit(const std::vector<Phase>& phases);

/// Keys of the root that read_phases() reads.
std::vector<Key> phases_keys();

/// Read "analysis", "time_integration", "walls" and "gravity_ramp" as the base, and "phases" if
/// there are any: each takes the base and replaces what it names. A ramp counts from the start of
/// the phase that names it and continues in the phases after it.
/// @returns at least one, in the order of time, the last one without end
/// @throws ConfigError
std::vector<Phase> read_phases(ConfigReader& in, int dim);

/// Give each phase the rigid walls that act in it: all, then those of the phase before.
/// @param in   of the root, for messages
/// @param all  names of the rigid walls
/// @throws ConfigError  a name that is none of them, or one that an earlier phase has dropped
void resolve_rigid_walls(const ConfigReader& in, const std::vector<std::string>& all,
                         std::vector<Phase>& phases);

/// Number of the phase of a step that starts at `time` [s].
std::size_t phase_at(const std::vector<Phase>& phases, double time);

/// Whether a phase looks for the factor of safety.
bool any_reduces_strength(const std::vector<Phase>& phases);

/// Whether a step that starts at `time` is the first one of the phase.
bool begins(const Phase& phase, double time);

/// Cause of the errors of require_within().
inline constexpr const char* phase_cause = "phase";

/// @throws ConvergenceError  a step of dt from `time` would pass the end of the phase or is longer
///                           than the phase allows; half of it may fit
void require_within(const Phase& phase, double time, double dt);

/// Largest step that the phase allows from `time` on [s]; 0: any.
double largest_step(const Phase& phase, double time);

}  // namespace gabion::mpm
