// SPDX-License-Identifier: BSD-3-Clause
#include "common/checkpoint/state_file.hpp"

#include <fmt/format.h>

#include "common/base/require.hpp"
#include "common/hdf5/hdf5_file.hpp"
#include "common/hdf5/hdf5_reader.hpp"
#include "common/settings/json_text.hpp"

namespace gabion {

void write_state(const std::string& path, const State& state) {
  Hdf5File file(path);
  file.write_text("facts", state.facts.dump());
  for (const auto& [name, values] : state.reals) {
    file.write("reals/" + name, 1, std::span<const double>(values));
  }
  for (const auto& [name, values] : state.integers) {
    file.write("integers/" + name, 1, std::span<const std::int64_t>(values));
  }
  file.finish();
}

State read_state(const std::string& path) {
  const Hdf5Reader file(path);
  State state;
  state.facts = parse_settings(file.text("facts"), path + ": dataset facts");
  require(state.facts.is_object(), "{}: dataset facts: found {}, allowed: an object", path,
          state.facts.type_name());
  for (const auto& name : file.names("reals")) state.reals[name] = file.reals("reals/" + name);
  for (const auto& name : file.names("integers")) {
    state.integers[name] = file.integers("integers/" + name);
  }
  return state;
}

}  // namespace gabion
