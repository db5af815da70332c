// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <thread>

#include "coupler/coupling_loop.hpp"
#include "coupler/run_coupler.hpp"
#include "protocol/serve.hpp"

namespace gabion::test {

/// Couple two solvers as in a real run, through the server and sockets; each solver serves in a
/// thread of its own. Writes the files of the run.
inline void couple_through_sockets(const CouplerSettings& settings, Solver& soil, Solver& structure,
                                   RunRecord& files, RunKeeper* keeper = nullptr) {
  Server server({"tcp://127.0.0.1:*", {}});
  const auto take_part = [&server](Solver& solver, const std::string& name, bool sends_force) {
    ParticipantSettings participant;
    participant.endpoint = server.endpoint();
    participant.name = name;
    participant.program = "test";
    participant.dimension = solver.interfaces().front().dim;
    participant.receives = sends_force ? displacement() : force();
    participant.sends = sends_force ? force() : displacement();
    participant.exit_when_coupler_is_lost = false;
    try {
      Connection connection(participant);
      serve(solver, connection);
    } catch (const ProtocolError&) {
      // the coupler ended the run and says why
    }
  };
  std::jthread soil_thread(take_part, std::ref(soil), "soil", true);
  std::jthread structure_thread(take_part, std::ref(structure), "structure", false);
  try {
    const auto solvers = server.wait_for(expected_participants(settings, "any"));
    CouplingLoop loop(settings,
                      {{"soil", *solvers.at("soil")}, {"structure", *solvers.at("structure")}},
                      files, keeper);
    loop.run();
    server.finish();
  } catch (const std::exception& error) {
    server.abort(error.what());
    throw;
  }
}

}  // namespace gabion::test
