// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstring>
#include <sstream>
#include <string>
#include <string_view>

#include "common/base/read_file.hpp"
#include "common/base/require.hpp"

namespace gabion {

/// The content of a surface file, read as words or as bytes, with the place for messages.
class SurfaceText {
 public:
  explicit SurfaceText(const std::string& path)
      : path_(path), text_(read_file(path, "surface file")) {}

  const std::string& all() const { return text_; }
  std::size_t bytes_left() const { return text_.size() - position_; }

  [[noreturn]] void fail(const std::string& message) const {
    const auto lines = std::count(text_.begin(), text_.begin() + position_, '\n');
    throw ConfigError(binary_ ? fmt::format("{}: byte {}: {}", path_, position_, message)
                              : fmt::format("{}: line {}: {}", path_, lines + 1, message));
  }

  /// Read numbers as bytes from now on. @param position  where they begin
  void read_bytes_from(std::size_t position) {
    position_ = position;
    binary_ = true;
  }

  /// The rest of the line, without its end.
  std::string_view line(const char* expected) {
    if (position_ >= text_.size()) fail(fmt::format("found the end, expected {}", expected));
    const std::size_t end = std::min(text_.find('\n', position_), text_.size());
    std::string_view result = std::string_view(text_).substr(position_, end - position_);
    position_ = std::min(end + 1, text_.size());
    if (result.ends_with('\r')) result.remove_suffix(1);
    return result;
  }

  /// The next characters up to white space.
  std::string_view word(const char* expected) {
    while (position_ < text_.size() && is_space(text_[position_])) ++position_;
    const std::size_t begin = position_;
    while (position_ < text_.size() && !is_space(text_[position_])) ++position_;
    if (begin == position_) fail(fmt::format("found the end, expected {}", expected));
    return std::string_view(text_).substr(begin, position_ - begin);
  }

  void expect(std::string_view allowed) {
    const std::string_view found = word(std::string(allowed).c_str());
    if (found != allowed) {
      fail(fmt::format("found \"{}\", expected \"{}\"", found.substr(0, 40), allowed));
    }
  }

  template <class T>
  T number(const char* expected) {
    T value{};
    if (binary_) {
      if (bytes_left() < sizeof(T)) fail(fmt::format("found the end, expected {}", expected));
      std::memcpy(&value, text_.data() + position_, sizeof(T));
      position_ += sizeof(T);
    } else {
      const std::string_view found = word(expected);
      const auto [end, error] = std::from_chars(found.data(), found.data() + found.size(), value);
      if (error != std::errc{} || end != found.data() + found.size()) {
        fail(fmt::format("found \"{}\", expected {}", found.substr(0, 40), expected));
      }
    }
    if (!std::isfinite(static_cast<double>(value))) {
      fail(fmt::format("found a number that is not finite, expected {}", expected));
    }
    return value;
  }

 private:
  static bool is_space(char c) { return c == ' ' || c == '\t' || c == '\n' || c == '\r'; }

  std::string path_, text_;
  std::size_t position_ = 0;
  bool binary_ = false;
};

}  // namespace gabion
