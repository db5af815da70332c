// SPDX-License-Identifier: BSD-3-Clause
#include "common/base/log.hpp"

#include <spdlog/sinks/basic_file_sink.h>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <cstdlib>
#include <utility>

#include "common/base/error.hpp"
#include "common/base/last_error.hpp"
#include "common/base/printable.hpp"

namespace gabion::log {

namespace {

spdlog::logger& logger() {
  // Heartbeats log from a thread of their own.
  static spdlog::logger instance("gabion", std::make_shared<spdlog::sinks::stderr_color_sink_mt>());
  return instance;
}

spdlog::level::level_enum to_spdlog(Level level) {
  switch (level) {
    case Level::debug:
      return spdlog::level::debug;
    case Level::info:
      return spdlog::level::info;
    case Level::warn:
      return spdlog::level::warn;
    case Level::error:
      return spdlog::level::err;
  }
  return spdlog::level::err;
}

std::string pattern = "[program] %^%v%$";

bool is_new_error(const std::string& text) {
  static std::string said;
  return std::exchange(said, text) != text;
}

}  // namespace

void start(std::string_view prefix, Level lowest, bool speaks) {
  pattern = fmt::format("[{}] %^%v%$", prefix);
  logger().set_pattern((on_terminal() ? erase_line : "") + pattern);
  logger().set_level(speaks ? to_spdlog(lowest) : spdlog::level::err);
  logger().flush_on(spdlog::level::debug);
}

bool on_terminal() {
  return isatty(STDERR_FILENO) == 1 || std::getenv("GABION_TERMINAL") != nullptr;
}

void also_to_file(const std::string& path) {
  auto sink = std::make_shared<spdlog::sinks::basic_file_sink_mt>(path, /*truncate=*/true);
  sink->set_pattern("%Y-%m-%d %H:%M:%S.%e " + pattern);
  logger().sinks().push_back(std::move(sink));
}

Level level_from_name(std::string_view name) {
  if (name == "debug") return Level::debug;
  if (name == "info") return Level::info;
  if (name == "warn") return Level::warn;
  if (name == "error") return Level::error;
  throw ConfigError(
      fmt::format("log level: found \"{}\", allowed: debug, info, warn, error", name));
}

void write(Level level, std::string_view text) {
  const char* mark = level == Level::error ? "error: " : level == Level::warn ? "warning: " : "";
  logger().log(to_spdlog(level), "{}{}", mark, printable(text));
}

void last_error(const std::string& text) {
  if (is_new_error(text)) write(Level::error, text);
}

void last_error_of_another(const std::string& text) {
  if (is_new_error(text)) write(Level::debug, text);
}

void last_error_to_file(const std::string& text) {
  if (!is_new_error(text)) return;
  auto& terminal = logger().sinks().front();
  const auto level = terminal->level();
  terminal->set_level(spdlog::level::off);
  write(Level::error, text);
  terminal->set_level(level);
}

}  // namespace gabion::log
