// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <fmt/format.h>

#include <string>
#include <string_view>
#include <utility>

namespace gabion::log {

enum class Level { debug, info, warn, error };

/// Set the prefix of every line (such as "mpm"), the lowest level shown, and whether this rank
/// speaks at all. Errors are shown on every rank.
void start(std::string_view prefix, Level lowest, bool speaks);

/// Write every line also, with date and time in front, to this file (flushed per line; an earlier
/// file is replaced). Call it before other threads log.
void also_to_file(const std::string& path);

/// Level from its name; throws ConfigError that lists the allowed names.
Level level_from_name(std::string_view name);

void write(Level level, std::string_view text);

template <class... Args>
void debug(fmt::format_string<Args...> text, Args&&... args) {
  write(Level::debug, fmt::format(text, std::forward<Args>(args)...));
}
template <class... Args>
void info(fmt::format_string<Args...> text, Args&&... args) {
  write(Level::info, fmt::format(text, std::forward<Args>(args)...));
}
template <class... Args>
void warn(fmt::format_string<Args...> text, Args&&... args) {
  write(Level::warn, fmt::format(text, std::forward<Args>(args)...));
}
template <class... Args>
void error(fmt::format_string<Args...> text, Args&&... args) {
  write(Level::error, fmt::format(text, std::forward<Args>(args)...));
}

/// Log the error that ends the program, once: the same text again is left out. The first to know it
/// logs it before telling others, whose ends may bring a signal that leaves no time for it.
void last_error(const std::string& text);

/// Whether a person watches stderr. Under mpirun it is a pipe even then; scripts/run sets
/// GABION_TERMINAL.
bool on_terminal();

/// Goes to the start of a terminal's line and erases it: what comes next takes the place of a live
/// progress line.
inline constexpr const char* erase_line = "\r\033[K";

}  // namespace gabion::log
