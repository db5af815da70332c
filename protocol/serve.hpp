// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "common/base/solver.hpp"
#include "protocol/connection.hpp"

namespace gabion {

/// Do what the coupler asks until the run is finished. Performs the handshake when the caller has
/// not done so.
///
/// A ConvergenceError of solve_step is told to the coupler, which decides what to do. Any other
/// exception of the solver is told to the coupler too, ends the run and is thrown on.
///
/// @throws ProtocolError  refused, coupler lost, or the coupler ended the run
void serve(Solver& solver, Connection& connection);

}  // namespace gabion
