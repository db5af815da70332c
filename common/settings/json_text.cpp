// SPDX-License-Identifier: BSD-3-Clause
#include "common/settings/json_text.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <vector>

#include "common/base/require.hpp"
#include "common/settings/json_fault.hpp"

namespace gabion {

namespace {

using Event = Json::parse_event_t;

/// Follows the parser through the text: knows the place, refuses repeated keys and deep nesting.
class ParseWatch {
 public:
  explicit ParseWatch(const std::string& source) : source_(source) {}

  void see(Event event, const Json& value) {
    switch (event) {
      case Event::object_start:
      case Event::array_start:
        enter(event == Event::array_start);
        break;
      case Event::object_end:
      case Event::array_end:
        levels_.pop_back();
        end_value();
        break;
      case Event::key:
        see_key(value.get<std::string>());
        break;
      case Event::value:
        end_value();
        break;
    }
  }

  /// "<source>: at <pointer>" of the value that is read.
  std::string where() const {
    Json::json_pointer pointer;
    for (const Level& level : levels_) {
      if (level.is_list) {
        pointer /= level.count;
      } else if (!level.keys.empty()) {
        pointer /= level.key;
      }
    }
    return fmt::format("{}: at {}", source_, pointer.empty() ? "/" : pointer.to_string());
  }

 private:
  struct Level {
    bool is_list;
    std::size_t count = 0;       // entries of a list that were read
    std::string key;             // the last one of an object
    std::set<std::string> keys;  // all of them
  };

  void enter(bool is_list) {
    require<ConfigError>(levels_.size() < max_settings_depth, [this] {
      return fmt::format("{}: found lists and objects nested deeper, allowed: {} levels", where(),
                         max_settings_depth);
    });
    levels_.push_back({is_list, 0, "", {}});
  }

  void see_key(const std::string& key) {
    Level& level = levels_.back();
    level.key = key;
    const bool is_new = level.keys.insert(key).second;
    require<ConfigError>(is_new, [this] {
      return fmt::format("{}: found this key a second time in its object, allowed: once", where());
    });
  }

  void end_value() {
    if (!levels_.empty()) ++levels_.back().count;
  }

  const std::string& source_;
  std::vector<Level> levels_;  // levels from the top object to the place
};

}  // namespace

Json parse_settings(const std::string& text, const std::string& source) {
  // The parser takes it for the end of the text, and what follows for nothing.
  const auto zero = std::find(text.begin(), text.end(), '\0');
  require<ConfigError>(zero == text.end(), "{}: not valid JSON: holds a byte 0 in line {}", source,
                       1 + std::count(text.begin(), zero, '\n'));
  ParseWatch watch(source);
  const auto see = [&watch](int, Event event, const Json& value) {
    watch.see(event, value);
    return true;
  };
  try {
    return Json::parse(text, see, true, /*ignore_comments=*/true);
  } catch (const Json::parse_error& error) {
    throw ConfigError(fmt::format("{}: not valid JSON: {}", source, fault_of(text, error)));
  } catch (const Json::out_of_range& error) {
    throw ConfigError(fmt::format("{}: {}, allowed: numbers up to 1.8e308", watch.where(),
                                  without_label(error.what())));
  }
}

}  // namespace gabion
