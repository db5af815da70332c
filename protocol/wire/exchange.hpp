// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "common/run/dt_range.hpp"
#include "common/run/solver.hpp"
#include "protocol/wire/message.hpp"

namespace gabion {

/// Requests and replies of the coupled step, from and to messages. Both ends use these, so that
/// each field is written and read in one place. All readers throw ProtocolError.

void put(Message& message, const StepRequest& request);
StepRequest read_step_request(const Message& message);

/// Put the proposed step sizes on which a "solve_step" behind an "accept_step" depends.
void put(Message& message, const DtRange& range);
/// Range that the message names; empty: the request depends on none.
std::optional<DtRange> read_dt_range(const Message& message);

void put(Message& message, const StepReport& report);
StepReport read_step_report(const Message& message);

void put(Message& message, const AcceptReport& report);
AcceptReport read_accept_report(const Message& message, std::size_t num_probes);

/// One array "<quantity>:<interface>" of num_vertices x dim an interface.
/// @throws ProtocolError  an interface is missing or unknown, a wrong number of values, or a value
///                        that is not finite: names quantity, interface, vertex and component
void put_values(Message& message, const std::string& quantity,
                const std::vector<InterfaceMesh>& interfaces, InterfaceValues values);
InterfaceValues read_values(Message message, const std::string& quantity,
                            const std::vector<InterfaceMesh>& interfaces);

/// Facts as the field "state", arrays "real:<name>" and "integer:<name>" of one dimension; the path
/// of a state that is in a file as "file".
void put(Message& message, const State& state);
/// Reply to "save".
Message saved(const State& state);
Message loaded(const std::vector<double>& probes);
/// Reply to "set_start".
Message start_set(const std::vector<double>& probes);
/// Arrays of other names are left out.
State read_state(const Message& message);

/// The bytes of a participant that keeps its state in a form of its own: the fact "bytes", their
/// number, and one array of that name, eight bytes a value (little-endian), filled up with zeros.
State pack_bytes(std::span<const std::byte> bytes);
/// @throws ProtocolError  not a state of pack_bytes()
std::vector<std::byte> unpack_bytes(const State& state);

/// `solve_step 57 iteration 3`: what a request asks, for phases and messages.
std::string describe(const Message& request);

}  // namespace gabion
