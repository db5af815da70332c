// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "common/checkpoint/checkpoints.hpp"
#include "common/run/time_steps.hpp"
#include "common/settings/scene.hpp"
#include "coupler/acceleration/acceleration.hpp"
#include "coupler/convergence/convergence.hpp"
#include "coupler/mapping/interface_map.hpp"
#include "protocol/server/server.hpp"

namespace gabion {

enum class Scheme {
  serial_implicit,    ///< soil, then structure, repeated until both agree
  parallel_implicit,  ///< both at once, repeated until both agree
  explicit_           ///< soil, then structure, once
};
std::string name(Scheme scheme);

/// Limits of dt by the number of coupling iterations; both counts are off at 0.
struct DtByIterations {
  int few = 0;   ///< dt may grow only while steps need no more than this
  int many = 0;  ///< the next step is halved after one that needed this or more; > few
};

/// Treatment of a step that is not converged after `max_iterations`.
enum class OnLimit { cut, stop, accept };

/// The "coupling" object of coupler.json.
struct CouplingSettings {
  Scheme scheme = Scheme::serial_implicit;
  int max_iterations = 50;  ///< coupling iterations of one step, >= 2
  OnLimit on_limit = OnLimit::cut;
  int predictor = 1;  ///< order of extrapolation, 0 to 2
  DtByIterations step_control;
  AccelerationSettings acceleration;
  ConvergenceSettings convergence;
  MappingSettings mapping;
};

/// A program or foreign code that takes part.
struct ParticipantRole {
  std::string name;
  bool sends_force = false;  ///< soil: force; structure: displacement
  /// Program and arguments that scripts/run starts in the scene's folder; empty = none.
  std::vector<std::string> command = {};
};

/// All of coupler.json.
struct CouplerSettings {
  TimeSettings time;
  double output_interval = 0;  ///< [s] > 0
  CheckpointSettings checkpoint;
  std::vector<ParticipantRole> participants;
  std::vector<InterfaceSettings> interfaces;
  CouplingSettings coupling;
  ServerSettings server;
};

KeyTable coupler_keys();
/// @param in  with coupler_keys()
/// @throws ConfigError  with file, JSON pointer, found and allowed
CouplerSettings read_coupler_settings(ConfigReader in);

}  // namespace gabion
