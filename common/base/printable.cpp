// SPDX-License-Identifier: BSD-3-Clause
#include "common/base/printable.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>

namespace gabion {
namespace {

bool is_plain_ascii(char c) {
  return (c >= ' ' && c <= '~') || c == '\t';
}

/// Length in bytes of the character at the start of a text; 0: it is not UTF-8 (RFC 3629).
std::size_t character_length(std::string_view text) {
  const auto byte = [text](std::size_t k) { return static_cast<std::uint8_t>(text[k]); };
  const std::uint8_t first = byte(0);
  const std::size_t length = first < 0x80                    ? 1
                             : first >= 0xC2 && first < 0xE0 ? 2
                             : first >= 0xE0 && first < 0xF0 ? 3
                             : first >= 0xF0 && first < 0xF5 ? 4
                                                             : 0;
  if (length == 0 || length > text.size()) return 0;
  for (std::size_t k = 1; k < length; ++k) {
    if ((byte(k) & 0xC0) != 0x80) return 0;
  }
  // The character is encoded too long, is half of a pair of UTF-16, or lies behind the last one.
  const bool wrong = (first == 0xE0 && byte(1) < 0xA0) || (first == 0xED && byte(1) > 0x9F) ||
                     (first == 0xF0 && byte(1) < 0x90) || (first == 0xF4 && byte(1) > 0x8F);
  return wrong ? 0 : length;
}

/// Whether a terminal obeys a character of several bytes: a control character, an end of line, or a
/// mark that changes the direction of writing.
bool is_obeyed(std::string_view character) {
  return (character[0] == '\xC2' && static_cast<std::uint8_t>(character[1]) < 0xA0) ||
         (character >= "\xE2\x80\xA8" && character <= "\xE2\x80\xAE") ||
         (character >= "\xE2\x81\xA6" && character <= "\xE2\x81\xA9") ||
         character == "\xE2\x80\x8E" || character == "\xE2\x80\x8F";
}

}  // namespace

std::string printable(std::string_view text) {
  if (std::all_of(text.begin(), text.end(), is_plain_ascii)) return std::string(text);
  std::string shown;
  while (!text.empty()) {
    const std::size_t length = character_length(text);
    const std::string_view character = text.substr(0, std::max<std::size_t>(length, 1));
    if (character == "\n") {
      shown += "\n    ";
    } else if (length > 1 ? !is_obeyed(character) : is_plain_ascii(text[0])) {
      shown += character;
    } else {
      for (const char c : character) {
        shown += fmt::format("\\x{:02x}", static_cast<std::uint8_t>(c));
      }
    }
    text.remove_prefix(character.size());
  }
  return shown;
}

}  // namespace gabion
