// SPDX-License-Identifier: BSD-3-Clause
#include "protocol/wire/force_kinds.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "common/base/require.hpp"

namespace gabion {

std::string name(ForceKind kind) {
  return kind == ForceKind::step_mean ? "step_mean" : "end_of_step";
}

ForceKind force_kind_of(const std::string& text, const std::string& where) {
  for (const ForceKind kind : {ForceKind::end_of_step, ForceKind::step_mean}) {
    if (text == name(kind)) return kind;
  }
  throw ProtocolError(
      fmt::format("{}: expected force_kind \"end_of_step\" or \"step_mean\", "
                  "found {}",
                  where, shortened(Json(text))));
}

Message to_message(const ForceKinds& kinds) {
  Message message = new_message("set_force_kinds");
  message.fields["kinds"] = Json::object();
  for (const auto& [interface, kind] : kinds) message.fields["kinds"][interface] = name(kind);
  return message;
}

ForceKinds read_force_kinds(const Message& message, const std::vector<InterfaceMesh>& interfaces) {
  const Json& list = message.field("kinds");
  require<ProtocolError>(list.is_object(),
                         "message \"{}\", field \"kinds\": expected an object, found {}",
                         message.type, shortened(list));
  ForceKinds kinds;
  for (const auto& entry : list.items()) {
    const std::string where = fmt::format("interface \"{}\"", entry.key());
    const bool known =
        std::any_of(interfaces.begin(), interfaces.end(),
                    [&](const InterfaceMesh& mesh) { return mesh.name == entry.key(); });
    require<ProtocolError>(known, "message \"{}\": {} is none of this participant", message.type,
                           where);
    require<ProtocolError>(entry.value().is_string(), "{}: expected force_kind as a text, found {}",
                           where, shortened(entry.value()));
    kinds[entry.key()] = force_kind_of(entry.value().get<std::string>(), where);
  }
  return kinds;
}

}  // namespace gabion
