// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "common/run/solver.hpp"
#include "protocol/wire/message.hpp"

namespace gabion {

/// "end_of_step" or "step_mean", as on the wire.
std::string name(ForceKind kind);
/// @param where  in messages
/// @throws ProtocolError  another text
ForceKind force_kind_of(const std::string& text, const std::string& where);

/// The request "set_force_kinds".
Message to_message(const ForceKinds& kinds);
/// @throws ProtocolError  an interface that is none of these, or no such kind
ForceKinds read_force_kinds(const Message& message, const std::vector<InterfaceMesh>& interfaces);

}  // namespace gabion
