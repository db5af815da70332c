// SPDX-License-Identifier: BSD-3-Clause
#include <CLI/CLI.hpp>
#include <gabion_version.hpp>

#include "common/base/error.hpp"
#include "common/base/log.hpp"
#include "element_test/run_element_test.hpp"

int main(int argc, char** argv) {
  using namespace gabion;
  element::ElementOptions options;
  CLI::App app("Computes a laboratory test on one element of a soil.", "element_test");
  app.add_option("test", options.test, "Stages of the test, element.json")->type_name("TEST");
  app.add_option("--output", options.output, "Table that is written")->type_name("FILE.csv");
  app.add_option("--scene", options.scene, "Scene whose mpm.json has the material")
      ->type_name("SCENE");
  app.add_option("--body", options.body, "Body of the scene (default: its only one)")
      ->type_name("NAME");
  app.add_option("--set", options.overrides, "Replace one value of the scene; may be repeated")
      ->type_name("FILE:/json/pointer=VALUE")
      ->expected(1)
      ->take_all();
  app.add_flag(
      "--describe-keys{markdown}", options.describe_keys,
      "Print all keys of the test as Markdown, or with =schema as a JSON Schema, then end");
  app.set_version_flag("--version", std::string("gabion ") + version);
  try {
    app.parse(argc, argv);
    if (options.describe_keys.empty() && options.test.empty()) throw CLI::RequiredError("test");
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }
  log::start("element", log::Level::info, true);
  try {
    element::run_element_test(options);
    return 0;
  } catch (const Error& error) {
    log::last_error(error.what());
    return error.exit_code();
  } catch (const std::exception& error) {
    log::last_error(error.what());
    return 4;
  }
}
