// SPDX-License-Identifier: BSD-3-Clause
#include "common/program/program.hpp"

#include <CLI/CLI.hpp>
#include <filesystem>
#include <gabion_version.hpp>

#include "common/base/error.hpp"
#include "common/base/log.hpp"
#include "common/program/freed_memory.hpp"
#include "common/program/programs.hpp"

namespace gabion {

namespace {

std::string default_output(const ProgramOptions& options, const std::string& program,
                           const MpiSession& session) {
  std::filesystem::path scene = std::filesystem::path(options.scene).lexically_normal();
  if (scene.filename().empty()) scene = scene.parent_path();
  const bool coupled = session.launched_with("coupler") || !options.coupler.empty();
  return "results/" + scene.filename().string() + (coupled ? "" : "_" + program);
}

void add_describe_keys(CLI::App& app, ProgramOptions& options) {
  app.add_flag("--describe-keys{markdown}", options.describe_keys,
               "Print all keys of its settings file as Markdown, or with =schema as a JSON Schema, "
               "then end");
}

/// Whether the program does without a scene.
bool needs_no_scene(const ProgramOptions& options) {
  return !options.make_keys.empty() || !options.describe_keys.empty();
}

}  // namespace

int run_program(int argc, char** argv, const std::string& program,
                const std::function<void(const ProgramOptions&, const MpiSession&)>& body) {
  keep_freed_memory();
  const ProgramEntry& role = program_entry(program);
  ProgramOptions options;
  options.name = role.participant;
  std::string log_level = "info";

  CLI::App app(role.about, program);
  CLI::Option* scene = app.add_option("scene", options.scene, "Scene folder")->type_name("SCENE");
  app.add_option("--output", options.output, "Folder of results (default: results/<scene>)")
      ->type_name("DIR");
  app.add_option("--restart", options.restart,
                 "Go on from the last checkpoint of the run with these results")
      ->type_name("DIR");
  app.add_option("--set", options.overrides, "Replace one value of the scene; may be repeated")
      ->type_name("FILE:/json/pointer=VALUE")
      ->expected(1)
      ->take_all();
  app.add_flag(
      "--check", options.check,
      "Check the scene, write nothing; in a launch as that of a run: up to the first step");
  add_describe_keys(app, options);
  app.add_option("--log-level", log_level, "debug, info, warn or error")->capture_default_str();
  app.add_option("--coupler", options.coupler,
                 program == "coupler" ? "Endpoint to bind, such as tcp://127.0.0.1:5555"
                                      : "Endpoint of a coupler outside this launch")
      ->type_name("ENDPOINT");
  app.add_option("--name", options.name, "Name of this participant")
      ->type_name("PARTICIPANT")
      ->capture_default_str();
  if (program == "coupler") {
    app.add_flag(
        "--list-participants", options.list_participants,
        "Print the endpoint, then name, program of this project that plays it (or nothing), "
        "number of words and words of each participant's command, then end; each item "
        "ends with a NUL");
    app.add_option(
           "--check-participant", options.check_participant,
           "Drive this participant alone through repeated, rejected and cut steps, then end")
        ->type_name("PARTICIPANT");
    app.add_option("--amplitude", options.amplitude,
                   "Random values of that check [N or m] (default: 1e-3 N, 1e-6 m)")
        ->check(CLI::PositiveNumber);
    app.add_option("--make-keys", options.make_keys,
                   "Write a new secret key to FILE and its public key to FILE.pub, then end")
        ->type_name("FILE");
  } else {
    app.add_option("--key-file", options.key_file, "Own secret key (or GABION_KEY_FILE)")
        ->type_name("FILE");
    app.add_option("--coupler-key-file", options.coupler_key_file,
                   "The coupler's public key (or GABION_COUPLER_KEY_FILE)")
        ->type_name("FILE");
    app.add_option("--connect-deadline", options.connect_deadline,
                   "Wait so long [s] for the coupler's answer")
        ->check(CLI::PositiveNumber)
        ->capture_default_str();
  }
  app.set_version_flag("--version", std::string("gabion ") + version);
  try {
    app.parse(argc, argv);
    if (scene->empty() && !needs_no_scene(options)) throw CLI::RequiredError("scene");
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }

  MpiSession session(argc, argv, program);
  log::start(role.prefix, log::Level::info, session.is_root());
  const auto fail = [&](const std::string& message, int exit_code) {
    log::error("{}", message);
    if (!session.is_only_process()) MpiSession::abort(exit_code);
    return exit_code;
  };
  const auto follow = [&](const Error& error, double head_start) {
    log::error("{}", error.what());
    if (!session.is_only_process()) MpiSession::leave(error.exit_code(), head_start);
    return error.exit_code();
  };
  try {
    log::start(role.prefix, log::level_from_name(log_level), session.is_root());
    if (options.output.empty()) options.output = default_output(options, program, session);
    body(options, session);
    return 0;
  } catch (const ProtocolError& error) {
    return follow(error, 0.5);  // mostly the echo of another program's failure
  } catch (const Error& error) {
    const bool by_signal = error.exit_code() > 128;
    return by_signal ? follow(error, 0) : fail(error.what(), error.exit_code());
  } catch (const std::exception& error) {
    return fail(error.what(), 1);
  }
}

}  // namespace gabion
