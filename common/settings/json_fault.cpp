// SPDX-License-Identifier: BSD-3-Clause
#include "common/settings/json_fault.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <map>
#include <string_view>

namespace gabion {

namespace {

/// The last character before `end` that is neither space nor in a comment; 0: there is none.
char last_before(const std::string& text, std::size_t end) {
  char last = 0;
  for (std::size_t at = 0; at < end;) {
    if (text[at] == '/' && text.compare(at, 2, "//") == 0) {
      at = text.find('\n', at);
    } else if (text[at] == '/' && text.compare(at, 2, "/*") == 0) {
      at = text.find("*/", at + 2);
      if (at != std::string::npos) at += 2;
    } else if (text[at] == '"') {
      last = '"';
      for (++at; at < end && text[at] != '"'; ++at) {
        if (text[at] == '\\') ++at;
      }
      ++at;
    } else {
      if (std::string_view(" \t\r\n").find(text[at]) == std::string_view::npos) last = text[at];
      ++at;
    }
  }
  return last;
}

std::string between(const std::string& text, const std::string& begin, const std::string& end) {
  const std::size_t at = text.find(begin);
  if (at == std::string::npos) return "";
  const std::size_t first = at + begin.size();
  const std::size_t last = end.empty() ? std::string::npos : text.find(end, first);
  return text.substr(first, last == std::string::npos ? last : last - first);
}

/// The parser's name of a token.
std::string plain(const std::string& token) {
  static const std::map<std::string, std::string> names = {{"string literal", "a text in quotes"},
                                                           {"number literal", "a number"},
                                                           {"true literal", "true"},
                                                           {"false literal", "false"},
                                                           {"null literal", "null"},
                                                           {"end of input", "the end of the file"},
                                                           {"'[', '{', or a literal", "a value"}};
  const auto found = names.find(token);
  if (found != names.end()) return found->second;
  if (token.size() == 3 && token.front() == '\'') return fmt::format("\"{}\"", token[1]);
  return token;
}

/// An entry may be followed by another one, or by the end of its list or object.
std::string allowed_instead(const std::string& expected) {
  if (expected == "'}'") return "\",\" or \"}\"";
  if (expected == "']'") return "\",\" or \"]\"";
  return plain(expected);
}

/// Text up to the place where a literal ends.
std::string word_before(const std::string& text, std::size_t end) {
  const std::size_t before =
      end == 0 ? std::string::npos : text.find_last_of(" \t\r\n{[,:", end - 1);
  const std::size_t first = before == std::string::npos ? 0 : before + 1;
  return text.substr(first, text.find_first_of(" \t\r\n}],:", first) - first);
}

/// Rewords what stands after "syntax error while parsing … - ".
std::string found_and_allowed(const std::string& words, const std::string& text, std::size_t at) {
  const std::string expected = between(words, "; expected ", "");
  const std::string unexpected = between(words, "unexpected ", "; expected ");
  if (!unexpected.empty()) {
    return fmt::format("found {}{}", plain(unexpected),
                       expected.empty() ? "" : ", allowed: " + allowed_instead(expected));
  }
  if (words.starts_with("invalid literal")) {
    const bool is_key = expected == "string literal";
    return fmt::format("found {}, allowed: {}", word_before(text, at),
                       is_key ? "a text in quotes"
                              : "a text in quotes, a number, true, false, null, a list, an object");
  }
  if (words.starts_with("invalid string: missing closing quote") || text[at] == '\n') {
    return "found a text without its closing quote in the same line";
  }
  return "found an " + words.substr(0, words.find("; last read"));
}

std::string place_of(const std::string& text, std::size_t at) {
  const auto end = text.begin() + static_cast<std::ptrdiff_t>(at);
  const auto line = 1 + std::count(text.begin(), end, '\n');
  const std::size_t before = at == 0 ? std::string::npos : text.rfind('\n', at - 1);
  return fmt::format("line {}, column {}", line,
                     before == std::string::npos ? at + 1 : at - before);
}

}  // namespace

std::string without_label(const std::string& what) {
  const std::size_t end = what.find("] ");
  return what.starts_with("[json.") && end != std::string::npos ? what.substr(end + 2) : what;
}

std::string fault_of(const std::string& text, const Json::parse_error& error) {
  const std::size_t at = std::min(error.byte == 0 ? 0 : error.byte - 1, text.size());
  const std::string place = place_of(text, at);
  const char found = at < text.size() ? text[at] : '\0';
  if ((found == '}' || found == ']') && last_before(text, at) == ',') {
    return fmt::format("{}: found \"{}\" after a comma, allowed: commas between entries only",
                       place, found);
  }
  const std::string what = without_label(error.what());
  const std::string words = between(what, " - ", "");
  return fmt::format("{}: {}", place, words.empty() ? what : found_and_allowed(words, text, at));
}

}  // namespace gabion
