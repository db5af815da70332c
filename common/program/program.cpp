// SPDX-License-Identifier: BSD-3-Clause
#include "common/program/program.hpp"

#include <filesystem>
#include <new>

#include "common/base/error.hpp"
#include "common/base/log.hpp"
#include "common/program/command_line.hpp"
#include "common/program/freed_memory.hpp"
#include "common/program/programs.hpp"

namespace gabion {

namespace {

constexpr int other_error = 4;  // such as that of Error

std::string default_output(const ProgramOptions& options, const std::string& program,
                           const MpiSession& session) {
  std::filesystem::path scene = std::filesystem::path(options.scene).lexically_normal();
  if (scene.filename().empty()) scene = scene.parent_path();
  const bool coupled = session.launched_with("coupler") || !options.coupler.empty();
  return "results/" + scene.filename().string() + (coupled ? "" : "_" + program);
}

int describe_keys_of(const ProgramEntry& role, const ProgramOptions& options,
                     const std::function<void(const std::string& form)>& describe) {
  try {
    describe(options.describe_keys);
    return 0;
  } catch (const Error& error) {
    log::start(role.prefix, log::Level::info, /*speaks=*/true);
    log::last_error(error.what());
    return error.exit_code();
  }
}

}  // namespace

int run_program(int argc, char** argv, const std::string& program,
                const std::function<void(const std::string& form)>& describe,
                const std::function<void(const ProgramOptions&, const MpiSession&)>& body) {
  keep_freed_memory();
  const ProgramEntry& role = program_entry(program);
  ProgramOptions options;
  options.name = role.participant;
  if (const auto exit_code = read_command_line(argc, argv, role, options)) return *exit_code;
  if (!options.describe_keys.empty()) return describe_keys_of(role, options, describe);

  MpiSession session(argc, argv, program);
  log::start(role.prefix, log::Level::info, session.is_root());
  const auto fail = [&](const std::string& message, int exit_code) {
    log::last_error(message);
    if (!session.is_only_process()) MpiSession::abort(exit_code);
    return exit_code;
  };
  const auto follow = [&](const Error& error, int head_start) {
    log::last_error(error.what());
    if (!session.is_only_process()) MpiSession::leave(error.exit_code(), head_start);
    return error.exit_code();
  };
  try {
    log::start(role.prefix, log::level_from_name(options.log_level), session.is_root());
    if (options.output.empty()) options.output = default_output(options, program, session);
    body(options, session);
    return 0;
  } catch (const ProtocolError& error) {
    return follow(error, 5);  // mostly the echo of another program's failure
  } catch (const Error& error) {
    const bool by_signal = error.exit_code() > 128;
    return by_signal ? follow(error, 0) : fail(error.what(), error.exit_code());
  } catch (const std::bad_alloc&) {
    return fail(options.scene + ": the memory of this machine is not enough for this scene; " +
                    "--check says how large the run will be",
                other_error);
  } catch (const std::exception& error) {
    return fail(error.what(), other_error);
  }
}

}  // namespace gabion
