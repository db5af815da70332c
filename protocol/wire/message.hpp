// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <variant>
#include <vector>

#include "common/base/error.hpp"
#include "common/base/json.hpp"

namespace gabion {

/// A named block of numbers, row-major.
struct Array {
  std::string name;
  std::vector<std::int64_t> shape;  ///< 1 to 4 extents >= 0; their product is the number of values
  std::variant<std::vector<double>, std::vector<std::int64_t>> values;

  std::size_t size() const;
};

/// One message of the protocol: a type, the sequence number of the request it is or answers, small
/// fields, and arrays. README.md lists the types and their fields.
struct Message {
  std::string type;
  std::uint64_t sequence = 0;
  Json fields = Json::object();  ///< without the reserved keys "type", "sequence", "arrays"
  std::vector<Array> arrays;

  void add(std::string name, std::vector<std::int64_t> shape, std::vector<double> values);
  void add(std::string name, std::vector<std::int64_t> shape, std::vector<std::int64_t> values);
  bool has_array(const std::string& name) const;

  /// Typed access. All throw ProtocolError with message type, name, what was expected and found.
  double number(const std::string& key) const;
  double positive_number(const std::string& key) const;
  std::int64_t integer(const std::string& key) const;
  bool boolean(const std::string& key) const;
  const std::string& text(const std::string& key) const;
  const Json& field(const std::string& key) const;
  /// An extent of -1 in `shape` accepts any.
  const std::vector<double>& reals(const std::string& name,
                                   const std::vector<std::int64_t>& shape) const;
  /// Like reals(), but the array is moved out of the message, which keeps an empty one.
  std::vector<double> take_reals(const std::string& name, const std::vector<std::int64_t>& shape);
  const std::vector<std::int64_t>& integers(const std::string& name,
                                            const std::vector<std::int64_t>& shape) const;

 private:
  const Array& array(const std::string& name, const std::vector<std::int64_t>& shape) const;
  [[noreturn]] void wrong(const std::string& key, const std::string& expected) const;
};

/// A message of this type, without arrays.
Message new_message(std::string type, Json fields = Json::object());

/// A JSON value for an error message, cut to 80 characters.
std::string shortened(const Json& value);

}  // namespace gabion
