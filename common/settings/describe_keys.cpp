// SPDX-License-Identifier: BSD-3-Clause
#include "common/settings/describe_keys.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>
#include <cstdio>
#include <sstream>

#include "common/base/require.hpp"

namespace gabion {

namespace {

/// A table and the pointers of the objects that it describes.
struct Section {
  const KeyTable* table;
  std::vector<std::string> places;
};

/// Sections in the order of the file, each table once.
void collect(const KeyTable& table, const std::string& place, std::vector<Section>& sections) {
  Section* known = nullptr;
  for (Section& section : sections) {
    if (section.table->name == table.name) known = &section;
  }
  if (known != nullptr) {
    if (known->places.back() != place) known->places.push_back(place);
    return;
  }
  sections.push_back({&table, {place}});
  for (const Key& key : table.keys) {
    if (!key.table) continue;
    const std::string in_list = key.type == KeyType::objects         ? "/#"
                                : key.type == KeyType::named_objects ? "/NAME"
                                                                     : "";
    collect(*key.table, place + (place.empty() ? "" : "/") + key.name + in_list, sections);
  }
}

std::string number_text(double x) {
  return fmt::format("{:.6g}", x);
}

std::string range_text(const Range& range) {
  const bool low = std::isfinite(range.low), high = std::isfinite(range.high);
  if (low && high && !range.low_open && !range.high_open) {
    return fmt::format("{} to {}", number_text(range.low), number_text(range.high));
  }
  const std::string above =
      low ? fmt::format("{} {}", range.low_open ? ">" : ">=", number_text(range.low)) : "";
  const std::string below =
      high ? fmt::format("{} {}", range.high_open ? "<" : "<=", number_text(range.high)) : "";
  return above + (low && high ? " and " : "") + below;
}

std::string words_text(const std::vector<std::string>& words) {
  return fmt::format("`{}`", fmt::join(words, "`, `"));
}

std::string range_text(const Key& key) {
  std::string result = key.words.empty() ? range_text(key.range) : words_text(key.words);
  if (key.min_size > 0) {
    result += fmt::format("{}at least {} of them", result.empty() ? "" : "; ", key.min_size);
  }
  return result;
}

std::string type_text(const Key& key) {
  std::string result = type_name(key.type);
  if (key.max_width > 0) {
    const std::string width = key.min_width == key.max_width
                                  ? std::to_string(key.min_width)
                                  : fmt::format("{} or {}", key.min_width, key.max_width);
    if (key.type == KeyType::vector) result = fmt::format("list of {} numbers", width);
    if (key.type == KeyType::integers) result = fmt::format("list of {} whole numbers", width);
    if (key.type == KeyType::rows) result = fmt::format("list of rows of {} numbers", width);
  }
  return result + (key.nullable ? " or null" : "");
}

std::string default_text(const Key& key) {
  switch (key.absence) {
    case Absence::refused:
      return "required";
    case Absence::computed:
      return key.computed;
    case Absence::none:
      return key.computed.empty() ? "none" : key.computed;
    case Absence::empty:
      return key.type == KeyType::object ? "its defaults" : "empty";
    case Absence::fallback:
      break;
  }
  if (key.fallback.is_string()) return fmt::format("`{}`", key.fallback.get<std::string>());
  return key.fallback.is_number() ? number_text(key.fallback.get<double>()) : key.fallback.dump();
}

std::string condition_text(const Condition& condition) {
  if (condition.words.empty()) {
    return fmt::format("{} `{}`", condition.given ? "with" : "without", condition.key);
  }
  return fmt::format("with `{}` {}", condition.key, words_text(condition.words));
}

std::string meaning(const Key& key) {
  std::vector<std::string> only;
  for (const Condition& condition : key.conditions) only.push_back(condition_text(condition));
  if (!key.circumstances.empty()) only.push_back(key.circumstances);
  std::string result = key.sentence;
  if (!only.empty()) result += fmt::format(" Only {}.", fmt::join(only, ", "));
  return result;
}

/// A cell of a table of Markdown.
std::string cell(const std::string& text) {
  std::string result;
  for (const char c : text) result += c == '|' ? std::string("\\|") : std::string(1, c);
  return result;
}

std::string row(const Key& key) {
  return fmt::format("| `{}` | {} | {} | {} | {} | {} |\n", key.name, type_text(key), key.unit,
                     cell(range_text(key)), cell(default_text(key)), cell(meaning(key)));
}

/// Places of a table, of many the first ones.
std::string places_text(const std::vector<std::string>& places) {
  constexpr std::size_t most = 6, shown = 2;
  if (places.size() <= most) return words_text(places);
  return fmt::format("{} and {} others", words_text({places.begin(), places.begin() + shown}),
                     places.size() - shown);
}

std::string one_of_text(const KeyTable& table) {
  if (table.one_of.empty()) return "";
  return fmt::format(" Exactly one of {}.", words_text(table.one_of));
}

/// Prose in lines of at most 118 characters.
std::string wrapped(const std::string& text) {
  constexpr std::size_t width = 118;
  std::string result, word;
  std::size_t column = 0;
  std::istringstream words(text);
  while (words >> word) {
    if (column > 0) {
      const bool fits = column + 1 + word.size() <= width;
      result += fits ? ' ' : '\n';
      column = fits ? column + 1 : 0;
    }
    result += word;
    column += word.size();
  }
  return result;
}

}  // namespace

std::string keys_as_markdown(const KeyTable& root, const std::string& file) {
  std::vector<Section> sections;
  collect(root, "", sections);
  std::string result = fmt::format(
      "# {}\n\n{}\n", file,
      wrapped(
          root.sentence +
          " A name has 1 to 64 letters, digits, `_` and `-`; `#` is the number of an entry of a "
          "list. Made by `--describe-keys`; `scripts/describe_keys` writes it anew."));
  for (const Section& section : sections) {
    const KeyTable& table = *section.table;
    if (&table != &root) {
      result += fmt::format("\n## {}\n\n{}\n", places_text(section.places),
                            wrapped(table.sentence + one_of_text(table)));
    }
    result += "\n| key | value | unit | range | default | meaning |\n";
    result += "| --- | --- | --- | --- | --- | --- |\n";
    for (const Key& key : table.keys) result += row(key);
  }
  return result;
}

void describe_keys(const KeyTable& root, const std::string& file, const std::string& form) {
  require<ConfigError>(form == "markdown" || form == "schema",
                       "--describe-keys: found \"{}\", allowed: markdown, schema", form);
  const std::string text =
      form == "markdown" ? keys_as_markdown(root, file) : keys_as_schema(root, file).dump(1) + "\n";
  std::fputs(text.c_str(), stdout);
}

}  // namespace gabion
