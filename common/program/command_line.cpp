// SPDX-License-Identifier: BSD-3-Clause
#include "common/program/command_line.hpp"

#include <CLI/CLI.hpp>
#include <gabion_version.hpp>

namespace gabion {

namespace {

void add_common_options(CLI::App& app, ProgramOptions& options, bool is_coupler) {
  app.add_option("scene", options.scene, "Scene folder")->type_name("SCENE");
  app.add_option("--output", options.output, "Folder of results (default: results/<scene>)")
      ->type_name("DIR");
  app.add_option("--restart", options.restart,
                 "Continue from the last checkpoint of the run with these results")
      ->type_name("DIR");
  app.add_option("--set", options.overrides, "Replace one value of the scene; may be repeated")
      ->type_name("FILE:/json/pointer=VALUE")
      ->expected(1)
      ->take_all();
  app.add_flag(
      "--check", options.check,
      "Check the scene and write nothing; when launched like a run, go as far as the first step");
  app.add_flag("--describe-keys{markdown}", options.describe_keys,
               "Print all keys of its settings file as Markdown, or with =schema as a JSON Schema, "
               "then end");
  app.add_option("--log-level", options.log_level, "debug, info, warn or error")
      ->capture_default_str();
  app.add_option("--coupler", options.coupler,
                 is_coupler ? "Endpoint to bind, such as tcp://127.0.0.1:5555"
                            : "Endpoint of a coupler outside this launch")
      ->type_name("ENDPOINT");
  app.add_option("--name", options.name, "Name of this participant")
      ->type_name("PARTICIPANT")
      ->capture_default_str();
}

void add_coupler_options(CLI::App& app, ProgramOptions& options) {
  app.add_flag("--list-participants", options.list_participants,
               "Print the endpoint, then name, program of this project that plays it (or nothing), "
               "number of words and words of each participant's command, then end; each item "
               "ends with a NUL");
  app.add_option("--check-participant", options.check_participant,
                 "Test this participant alone: repeated, rejected and cut steps, then end")
      ->type_name("PARTICIPANT");
  app.add_option("--amplitude", options.amplitude,
                 "Size of the random values of that test [N or m] (default: 1e-3 N, 1e-6 m)")
      ->check(CLI::PositiveNumber);
  app.add_option("--make-keys", options.make_keys,
                 "Write a new secret key to FILE and its public key to FILE.pub, then end")
      ->type_name("FILE");
}

void add_solver_options(CLI::App& app, ProgramOptions& options) {
  app.add_option("--key-file", options.key_file, "Own secret key (or GABION_KEY_FILE)")
      ->type_name("FILE");
  app.add_option("--coupler-key-file", options.coupler_key_file,
                 "The coupler's public key (or GABION_COUPLER_KEY_FILE)")
      ->type_name("FILE");
  app.add_option("--connect-deadline", options.connect_deadline,
                 "Time to wait for the coupler's answer [s]")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
}

}  // namespace

std::optional<int> read_command_line(int argc, char** argv, const ProgramEntry& program,
                                     ProgramOptions& options) {
  CLI::App app(program.about, program.name);
  const bool is_coupler = program.name == coupler_program().name;
  add_common_options(app, options, is_coupler);
  if (is_coupler) {
    add_coupler_options(app, options);
  } else {
    add_solver_options(app, options);
  }
  if (program.name == "fem_solver") {
    app.add_option("--write-matrices", options.write_matrices,
                   "Write the structure as matrices and a fem.json that reads them to FOLDER, then "
                   "end")
        ->type_name("FOLDER");
  }
  if (program.name == "mpm_solver") {
    app.add_option("--advise-ranks", options.advise_ranks,
                   "Print how many MPI ranks pay on so many cores (0: those that it may use and "
                   "that are idle) and why, each item ended by a NUL, then end")
        ->type_name("CORES")
        ->check(CLI::NonNegativeNumber);
    app.add_option(
           "--write-varying", options.write_varying,
           "Write the material points at the start with the constants of the materials that "
           "vary in space to FILE, a table, then end")
        ->type_name("FILE");
  }
  app.set_version_flag("--version", std::string("gabion ") + version);
  try {
    app.parse(argc, argv);
    const bool needs_scene = options.make_keys.empty() && options.describe_keys.empty();
    if (needs_scene && options.scene.empty()) throw CLI::RequiredError("scene");
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }
  return std::nullopt;
}

}  // namespace gabion
