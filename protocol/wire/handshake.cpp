// SPDX-License-Identifier: BSD-3-Clause
#include "protocol/wire/handshake.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <set>

#include "common/base/names.hpp"
#include "common/base/require.hpp"
#include "protocol/wire/codec.hpp"
#include "protocol/wire/force_kinds.hpp"

namespace gabion {
namespace {

constexpr auto scene_hash = "scene hash";

Json to_json(const Quantity& quantity) {
  return {{"quantity", quantity.name}, {"unit", quantity.unit}};
}

std::string to_text(const Quantity& quantity) {
  return fmt::format("{} [{}]", quantity.name, quantity.unit);
}

Json to_json(const ProcessIdentity& process) {
  return {{"host", process.host}, {"pid", process.pid}, {"start_time", process.start_time}};
}

/// A nested object of a message, read with the same typed access.
Message nested(const Message& message, const std::string& key) {
  const Json& value = message.field(key);
  require<ProtocolError>(value.is_object(),
                         "message \"{}\", field \"{}\": expected an object, found {}", message.type,
                         key, shortened(value));
  return new_message(message.type + "." + key, value);
}

Quantity read_quantity(const Message& message, const std::string& key) {
  const Message in = nested(message, key);
  return {in.text("quantity"), in.text("unit")};
}

ProcessIdentity read_process(const Message& message) {
  const Message in = nested(message, "process");
  return {in.text("host"), in.integer("pid"), in.integer("start_time")};
}

/// A list of a message, each element an object.
std::vector<Message> nested_list(const Message& message, const std::string& key) {
  const Json& list = message.field(key);
  std::vector<Message> out;
  require<ProtocolError>(list.is_array(), "message \"{}\", field \"{}\": expected a list, found {}",
                         message.type, key, shortened(list));
  for (const Json& element : list) {
    require<ProtocolError>(element.is_object(),
                           "message \"{}\", field \"{}\": expected objects, found {}", message.type,
                           key, shortened(element));
    out.push_back(new_message(message.type + "." + key, element));
  }
  return out;
}

std::vector<std::string> read_texts(const Message& message, const std::string& key) {
  const Json& list = message.field(key);
  const bool texts = list.is_array() && std::all_of(list.begin(), list.end(),
                                                    [](const Json& j) { return j.is_string(); });
  require<ProtocolError>(texts, "message \"{}\", field \"{}\": expected a list of texts, found {}",
                         message.type, key, shortened(list));
  return list.get<std::vector<std::string>>();
}

InterfaceMesh read_interface(const Message& hello, const Message& description, int dim) {
  InterfaceMesh mesh;
  mesh.name = description.text("name");
  mesh.dim = dim;
  const std::int64_t width = description.integer("vertices_per_facet");
  require<ProtocolError>(width == 0 || (width >= 2 && width <= 4),
                         "interface \"{}\": expected 0, 2, 3 or 4 vertices_per_facet, found {}",
                         mesh.name, width);
  mesh.vertices_per_facet = static_cast<int>(width);
  if (description.fields.contains("force_kind")) {
    mesh.force_kind =
        force_kind_of(description.text("force_kind"), fmt::format("interface \"{}\"", mesh.name));
  }
  mesh.coordinates = hello.reals("coordinates:" + mesh.name, {-1, dim});
  require_finite(mesh.coordinates, static_cast<std::size_t>(dim), "coordinates:" + mesh.name);
  if (width == 0) return mesh;
  mesh.facets = hello.integers("facets:" + mesh.name, {-1, width});
  for (const std::int64_t vertex : mesh.facets) {
    require<ProtocolError>(vertex >= 0 && vertex < mesh.num_vertices(),
                           "interface \"{}\": a facet names vertex {}, there are {}", mesh.name,
                           vertex, mesh.num_vertices());
  }
  return mesh;
}

std::string start_array(const InterfaceMesh& mesh) {
  return displacement().name + ":" + mesh.name;
}

/// Displacements in the initial state, of the interfaces that have any.
InterfaceValues read_start(const Message& hello, const std::vector<InterfaceMesh>& interfaces) {
  InterfaceValues start;
  for (const InterfaceMesh& mesh : interfaces) {
    const std::string array = start_array(mesh);
    if (!hello.has_array(array)) continue;
    start[mesh.name] = hello.reals(array, {mesh.num_vertices(), mesh.dim});
    require_finite(start[mesh.name], static_cast<std::size_t>(mesh.dim), array);
  }
  return start;
}

/// Names of columns in tables. @param more  characters that are allowed beside those of plain names
void require_names(const char* what, const std::vector<std::string>& names,
                   const std::string& more) {
  std::set<std::string> before;
  for (const std::string& name : names) {
    require<ProtocolError>(is_plain_name(name, more), [&] {
      return fmt::format("{}: found {}, allowed: letters, digits and one of \"_-{}\"", what,
                         shortened(Json(name)), more);
    });
    require<ProtocolError>(before.insert(name).second, "{}: found \"{}\" twice, allowed: once",
                           what, name);
  }
}

}  // namespace

bool is_participant_name(const std::string& text) {
  return is_plain_name(text, ".") && text.size() <= max_name_size;
}

Message to_message(const Hello& hello) {
  Message out = new_message("hello");
  out.fields = {
      {"protocol", hello.protocol},         {"participant", hello.participant},
      {"program", hello.program},           {"program_version", hello.program_version},
      {"session", hello.session},           {"scene_hash", hello.scene_hash},
      {"dimension", hello.dimension},       {"receives", to_json(hello.receives)},
      {"sends", to_json(hello.sends)},      {"convention", hello.convention},
      {"interfaces", Json::array()},        {"probe_names", hello.probe_names},
      {"heartbeat", hello.sends_heartbeat}, {"process", to_json(hello.process)},
      {"keeps_state", hello.keeps_state},   {"takes_force_kinds", hello.takes_force_kinds},
      {"takes_start", hello.takes_start},   {"takes_next_step", hello.takes_next_step}};
  for (const InterfaceMesh& mesh : hello.interfaces) {
    out.fields["interfaces"].push_back({{"name", mesh.name},
                                        {"vertices_per_facet", mesh.vertices_per_facet},
                                        {"force_kind", name(mesh.force_kind)}});
    if (std::ranges::find(hello.changing, mesh.name) != hello.changing.end()) {
      out.fields["interfaces"].back()["facets_may_change"] = true;
    }
    out.add("coordinates:" + mesh.name, {mesh.num_vertices(), mesh.dim}, mesh.coordinates);
    if (const auto start = hello.start.find(mesh.name); start != hello.start.end()) {
      out.add(start_array(mesh), {mesh.num_vertices(), mesh.dim}, start->second);
    }
    if (mesh.vertices_per_facet == 0) continue;
    out.add("facets:" + mesh.name,
            {static_cast<std::int64_t>(mesh.facets.size()) / mesh.vertices_per_facet,
             mesh.vertices_per_facet},
            mesh.facets);
  }
  if (hello.takes_facets) out.fields["takes_facets"] = true;
  out.add("probes", {static_cast<std::int64_t>(hello.probes.size())}, hello.probes);
  return out;
}

Message to_message(const Welcome& welcome) {
  Message out = new_message("welcome");
  out.fields = {{"protocol", welcome.protocol},
                {"program_version", welcome.program_version},
                {"process", to_json(welcome.process)},
                {"silence_deadline", welcome.deadlines.silence},
                {"idle_deadline", welcome.deadlines.idle},
                {"heartbeat", welcome.deadlines.heartbeat},
                {"run", welcome.run}};
  return out;
}

Message refusal(const std::vector<Mismatch>& mismatches) {
  Message out = new_message("refused");
  out.fields["reason"] = mismatch_text(mismatches);
  out.fields["mismatches"] = Json::array();
  for (const Mismatch& m : mismatches) {
    out.fields["mismatches"].push_back(
        {{"what", m.what}, {"coupler", m.coupler}, {"participant", m.participant}});
  }
  return out;
}

std::string text_or_empty(const Message& message, const char* key) {
  const auto field = message.fields.find(key);
  return field != message.fields.end() && field->is_string() ? field->get<std::string>() : "";
}

Hello read_hello(const Message& message) {
  Hello hello;
  hello.protocol = message.text("protocol");
  hello.participant = message.text("participant");
  require<ProtocolError>(
      is_participant_name(hello.participant),
      "message \"hello\", field \"participant\": expected 1 to 64 letters, digits, "
      "\"_\", \"-\" or \".\", found " +
          shortened(message.field("participant")));
  hello.program = message.text("program");
  hello.program_version = message.text("program_version");
  hello.session = message.text("session");
  hello.scene_hash = message.text("scene_hash");
  const std::int64_t dimension = message.integer("dimension");
  require<ProtocolError>(dimension == 2 || dimension == 3,
                         "message \"hello\": expected dimension 2 or 3, found {}", dimension);
  hello.dimension = static_cast<int>(dimension);
  hello.receives = read_quantity(message, "receives");
  hello.sends = read_quantity(message, "sends");
  hello.convention = message.text("convention");
  hello.probe_names = read_texts(message, "probe_names");
  require_names("probe_names", hello.probe_names, ". ");
  hello.probes = message.reals("probes", {static_cast<std::int64_t>(hello.probe_names.size())});
  hello.sends_heartbeat = message.boolean("heartbeat");
  hello.process = read_process(message);
  for (const auto& [key, flag] : {std::pair("keeps_state", &hello.keeps_state),
                                  std::pair("takes_force_kinds", &hello.takes_force_kinds),
                                  std::pair("takes_start", &hello.takes_start),
                                  std::pair("takes_facets", &hello.takes_facets),
                                  std::pair("takes_next_step", &hello.takes_next_step)}) {
    if (message.fields.contains(key)) *flag = message.boolean(key);
  }
  const std::vector<Message> descriptions = nested_list(message, "interfaces");
  std::vector<std::string> names;
  for (const Message& description : descriptions) names.push_back(description.text("name"));
  require_names("names of interfaces", names, ".");
  for (const Message& description : descriptions) {
    hello.interfaces.push_back(read_interface(message, description, hello.dimension));
    if (description.fields.contains("facets_may_change") &&
        description.boolean("facets_may_change")) {
      const InterfaceMesh& mesh = hello.interfaces.back();
      require<ProtocolError>(mesh.vertices_per_facet > 0,
                             "interface \"{}\": found \"facets_may_change\" without facets",
                             mesh.name);
      hello.changing.push_back(mesh.name);
    }
  }
  if (hello.sends == displacement()) hello.start = read_start(message, hello.interfaces);
  return hello;
}

Welcome read_welcome(const Message& message) {
  Welcome welcome;
  welcome.protocol = message.text("protocol");
  welcome.program_version = message.text("program_version");
  welcome.process = read_process(message);
  welcome.deadlines.silence = message.positive_number("silence_deadline");
  welcome.deadlines.idle = message.positive_number("idle_deadline");
  welcome.deadlines.heartbeat = message.positive_number("heartbeat");
  welcome.run = nested(message, "run").fields;
  return welcome;
}

int major_version(const std::string& version) {
  int major = -1;
  const char* end = version.data() + version.size();
  const auto [stop, problem] = std::from_chars(version.data(), end, major);
  require<ProtocolError>(problem == std::errc() && major >= 0 && stop != end && *stop == '.',
                         "protocol version: expected \"major.minor\", found {}",
                         shortened(Json(version)));
  return major;
}

std::vector<Mismatch> compare(const Expected& expected, const Hello& hello) {
  std::vector<Mismatch> found;
  const auto check = [&found](bool equal, const char* what, std::string ours, std::string theirs) {
    if (!equal) found.push_back({what, std::move(ours), std::move(theirs)});
  };
  check(expected.scene_hash.empty() || hello.scene_hash.empty() ||
            expected.scene_hash == hello.scene_hash,
        scene_hash, expected.scene_hash, hello.scene_hash);
  check(expected.dimension == 0 || expected.dimension == hello.dimension, "dimension",
        std::to_string(expected.dimension), std::to_string(hello.dimension));
  check(expected.receives == hello.receives, "quantity that the participant receives",
        to_text(expected.receives), to_text(hello.receives));
  check(expected.sends == hello.sends, "quantity that the participant sends",
        to_text(expected.sends), to_text(hello.sends));
  check(hello.convention == sign_convention, "sign convention", sign_convention, hello.convention);
  const std::set<std::string> ours(expected.interfaces.begin(), expected.interfaces.end());
  std::set<std::string> theirs;
  for (const InterfaceMesh& mesh : hello.interfaces) theirs.insert(mesh.name);
  check(ours == theirs, "interfaces", fmt::format("{}", ours), fmt::format("{}", theirs));
  return found;
}

std::string mismatch_text(const std::vector<Mismatch>& mismatches) {
  std::string text;
  for (const Mismatch& m : mismatches) {
    text += fmt::format("{}{}: coupler {}, participant {}", text.empty() ? "" : "; ", m.what,
                        m.coupler.empty() ? "\"\"" : m.coupler,
                        m.participant.empty() ? "\"\"" : m.participant);
    if (m.what == scene_hash) {
      text += " (all programs of a run take the same scene and the same --set)";
    }
  }
  return text;
}

}  // namespace gabion
