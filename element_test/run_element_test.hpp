// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

namespace gabion::element {

/// Options of the command line.
struct ElementOptions {
  std::string test;    ///< element.json
  std::string output;  ///< table that is written
  std::string scene;   ///< folder whose mpm.json has the material; empty: test has it
  std::string body;    ///< of the scene; empty: its only one
  std::vector<std::string> overrides;  ///< for Scene
  std::string describe_keys;           ///< "markdown" or "schema": print the keys, then end
};

/// Run the test. Rows of a test that could not be followed to its end stay in the table.
/// @throws Error
void run_element_test(const ElementOptions& options);

}  // namespace gabion::element
