// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "common/base/process.hpp"
#include "common/run/solver.hpp"
#include "protocol/wire/deadlines.hpp"
#include "protocol/wire/message.hpp"

namespace gabion {

/// Version of the wire contract, "major.minor". Majors must agree.
inline constexpr const char* protocol_version = "1.4";

/// The sign convention of all values on the wire; both sides must name the same one.
inline constexpr const char* sign_convention =
    "displacement: total from reference; force: by soil on structure";

/// A quantity that is exchanged, such as {"displacement", "m"} or {"force", "N"}.
struct Quantity {
  std::string name;
  std::string unit;
  bool operator==(const Quantity&) const = default;
};
inline Quantity displacement() {
  return {"displacement", "m"};
}
inline Quantity force() {
  return {"force", "N"};
}

/// Whether a text is 1 to 64 letters, digits, "_", "-" and ".".
bool is_participant_name(const std::string& text);

/// Data of a participant about itself.
struct Hello {
  std::string protocol = protocol_version;
  std::string participant;  ///< its name in coupler.json: letters, digits, "_", "-", "."
  std::string program;      ///< such as "fem_solver"
  std::string program_version;
  std::string session;     ///< random text, unique to this start of the participant
  std::string scene_hash;  ///< empty = a foreign code that does not read the scene
  int dimension = 0;
  Quantity receives;
  Quantity sends;
  std::string convention = sign_convention;
  std::vector<InterfaceMesh> interfaces;
  std::vector<std::string> probe_names;
  std::vector<double> probes;         ///< values in the initial state
  InterfaceValues start;              ///< displacements there, of interfaces where any is not zero
  bool keeps_state = false;           ///< it answers "save" and "load"
  bool takes_force_kinds = false;     ///< it answers "set_force_kinds"
  bool takes_start = false;           ///< it answers "set_start"
  bool takes_facets = false;          ///< it answers "set_facets"
  std::vector<std::string> changing;  ///< interfaces whose facets may change
  bool takes_next_step = false;  ///< it accepts "solve_step" before it has answered "accept_step"
  bool sends_heartbeat = true;   ///< false: judged by its process and the answer deadline alone
  ProcessIdentity process;
};

/// The coupler's answer to an accepted hello.
struct Welcome {
  std::string protocol = protocol_version;
  std::string program_version;
  ProcessIdentity process;
  Deadlines deadlines;
  Json run = Json::object();  ///< settings of the run: end time, dt, folders, ...
};

/// Requirements of the coupler on a participant.
struct Expected {
  std::string name;
  std::string scene_hash;               ///< empty = any
  int dimension = 0;                    ///< 2 or 3; 0 = any
  std::vector<std::string> interfaces;  ///< exactly these, in any order
  Quantity receives;
  Quantity sends;
};

/// One disagreement, in the words of both sides.
struct Mismatch {
  std::string what;
  std::string coupler;
  std::string participant;
};

Message to_message(const Hello& hello);
Message to_message(const Welcome& welcome);
Message refusal(const std::vector<Mismatch>& mismatches);

/// @throws ProtocolError  a field is missing or senseless: non-finite coordinates, facets that name
///                        vertices which do not exist, ...
Hello read_hello(const Message& message);
Welcome read_welcome(const Message& message);
/// A field of a hello, or of an abort before it, which may not be complete; empty: no such text.
std::string text_or_empty(const Message& message, const char* key);

/// The major of "major.minor".
/// @throws ProtocolError  no version
int major_version(const std::string& version);

/// All disagreements between what is expected and what came, other than the protocol version.
std::vector<Mismatch> compare(const Expected& expected, const Hello& hello);

/// `dimension: coupler 2, participant 3; scene hash: …`
std::string mismatch_text(const std::vector<Mismatch>& mismatches);

}  // namespace gabion
