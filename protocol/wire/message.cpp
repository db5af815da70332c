// SPDX-License-Identifier: BSD-3-Clause
#include "protocol/wire/message.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "common/base/require.hpp"

namespace gabion {

std::size_t Array::size() const {
  return std::visit([](const auto& list) { return list.size(); }, values);
}

std::string shortened(const Json& value) {
  std::string text = value.dump(-1, ' ', true, Json::error_handler_t::replace);
  if (text.size() > 80) text = text.substr(0, 77) + "...";
  return text;
}

Message new_message(std::string type, Json fields) {
  return {.type = std::move(type), .sequence = 0, .fields = std::move(fields), .arrays = {}};
}

void Message::add(std::string name, std::vector<std::int64_t> shape, std::vector<double> values) {
  arrays.push_back({std::move(name), std::move(shape), std::move(values)});
}

void Message::add(std::string name, std::vector<std::int64_t> shape,
                  std::vector<std::int64_t> values) {
  arrays.push_back({std::move(name), std::move(shape), std::move(values)});
}

bool Message::has_array(const std::string& name) const {
  return std::any_of(arrays.begin(), arrays.end(),
                     [&name](const Array& array) { return array.name == name; });
}

void Message::wrong(const std::string& key, const std::string& expected) const {
  const auto found = fields.find(key);
  throw ProtocolError(fmt::format("message \"{}\", field \"{}\": expected {}, found {}", type, key,
                                  expected, found == fields.end() ? "nothing" : shortened(*found)));
}

const Json& Message::field(const std::string& key) const {
  const auto found = fields.find(key);
  if (found == fields.end()) wrong(key, "a value");
  return *found;
}

double Message::number(const std::string& key) const {
  const auto found = fields.find(key);
  if (found == fields.end() || !found->is_number()) wrong(key, "a number");
  return found->get<double>();
}

double Message::positive_number(const std::string& key) const {
  const double value = number(key);
  if (!(value > 0)) wrong(key, "a number > 0");
  return value;
}

std::int64_t Message::integer(const std::string& key) const {
  const auto found = fields.find(key);
  if (found == fields.end() || !found->is_number_integer()) wrong(key, "an integer");
  if (found->is_number_unsigned() && found->get<std::uint64_t>() > INT64_MAX) {
    wrong(key, "a signed 64-bit integer");
  }
  return found->get<std::int64_t>();
}

bool Message::boolean(const std::string& key) const {
  const auto found = fields.find(key);
  if (found == fields.end() || !found->is_boolean()) wrong(key, "true or false");
  return found->get<bool>();
}

const std::string& Message::text(const std::string& key) const {
  const auto found = fields.find(key);
  if (found == fields.end() || !found->is_string()) wrong(key, "a text");
  return found->get_ref<const std::string&>();
}

const Array& Message::array(const std::string& name, const std::vector<std::int64_t>& shape) const {
  for (const Array& candidate : arrays) {
    if (candidate.name != name) continue;
    bool equal = candidate.shape.size() == shape.size();
    for (std::size_t i = 0; equal && i < shape.size(); ++i) {
      equal = shape[i] < 0 || shape[i] == candidate.shape[i];
    }
    require<ProtocolError>(equal, "message \"{}\", array \"{}\": expected shape [{}], found [{}]",
                           type, name, fmt::join(shape, ", "), fmt::join(candidate.shape, ", "));
    return candidate;
  }
  throw ProtocolError(
      fmt::format("message \"{}\": expected an array \"{}\" of shape [{}], found none", type, name,
                  fmt::join(shape, ", ")));
}

const std::vector<double>& Message::reals(const std::string& name,
                                          const std::vector<std::int64_t>& shape) const {
  const auto* values = std::get_if<std::vector<double>>(&array(name, shape).values);
  require<ProtocolError>(values != nullptr,
                         "message \"{}\", array \"{}\": expected \"<f8\", found \"<i8\"", type,
                         name);
  return *values;
}

std::vector<double> Message::take_reals(const std::string& name,
                                        const std::vector<std::int64_t>& shape) {
  reals(name, shape);
  const auto found = std::find_if(arrays.begin(), arrays.end(),
                                  [&name](const Array& array) { return array.name == name; });
  return std::move(std::get<std::vector<double>>(found->values));
}

const std::vector<std::int64_t>& Message::integers(const std::string& name,
                                                   const std::vector<std::int64_t>& shape) const {
  const auto* values = std::get_if<std::vector<std::int64_t>>(&array(name, shape).values);
  require<ProtocolError>(values != nullptr,
                         "message \"{}\", array \"{}\": expected \"<i8\", found \"<f8\"", type,
                         name);
  return *values;
}

}  // namespace gabion
