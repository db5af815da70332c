// SPDX-License-Identifier: BSD-3-Clause
#include "element_test/run_element_test.hpp"

#include <optional>

#include "common/base/read_file.hpp"
#include "common/base/require.hpp"
#include "common/settings/describe_keys.hpp"
#include "common/settings/json_text.hpp"
#include "element_test/element_table.hpp"

namespace gabion::element {

namespace {

ElementSettings read_settings(const ElementOptions& options) {
  require<ConfigError>(
      !options.scene.empty() || (options.body.empty() && options.overrides.empty()),
      "--body, --set: allowed only with --scene");
  ConfigReader in(parse_settings(read_file(options.test, "settings file"), options.test),
                  options.test, element_keys());
  if (options.scene.empty()) return read_element_settings(in, nullptr);
  const Scene scene(options.scene, options.overrides);
  const TestedBody body{scene, options.body};
  return read_element_settings(in, &body);
}

}  // namespace

void run_element_test(const ElementOptions& options) {
  if (!options.describe_keys.empty()) {
    describe_keys(element_keys(), "element.json", options.describe_keys);
    return;
  }
  const ElementSettings settings = read_settings(options);
  require<ConfigError>(!options.output.empty(),
                       "--output: found none, allowed: a file for the table");
  ElementState state = ElementPoint(settings).start();
  ElementTable table(options.output, settings.material.law);
  table.row("start", state, {});
  for (const StageSettings& stage : settings.stages) {
    follow_stage(settings, stage, state, [&](const ElementState& reached, const Effort& effort) {
      table.row(stage.name, reached, effort);
    });
  }
}

}  // namespace gabion::element
