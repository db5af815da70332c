// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>

#include "common/run/solver.hpp"
#include "protocol/participant/connection.hpp"
#include "protocol/participant/request_source.hpp"

namespace gabion {

/// Do what the coupler asks until the run is finished. Performs the handshake when the caller has
/// not done so, then calls `welcomed`, if given: now the coupler has made the folder of results.
///
/// A ConvergenceError of solve_step is told to the coupler, which decides what to do. Any other
/// exception of the solver, or of `welcomed`, is told to the coupler too, ends the run and is
/// thrown on.
///
/// @throws ProtocolError  refused, coupler lost, or the coupler ended the run
void serve(Solver& solver, Connection& connection, const std::function<void()>& welcomed = {});

/// Like serve() with a connection, after the handshake, where another object stands between the
/// connection and the solver.
/// @param requests  gives on what the connection gets
void serve(Solver& solver, Connection& connection, RequestSource& requests);

/// Have the solver carry out the requests until the run is finished.
/// @param receives, sends  by the solver
/// @throws ProtocolError  a request that is unknown, not allowed now, or not complete
/// @throws Error          of the solver, but for a ConvergenceError of solve_step
void answer_requests(Solver& solver, const Quantity& receives, const Quantity& sends,
                     RequestSource& requests);

}  // namespace gabion
