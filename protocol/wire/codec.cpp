// SPDX-License-Identifier: BSD-3-Clause
#include "protocol/wire/codec.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <set>

#include "common/base/require.hpp"

namespace gabion {
namespace {

static_assert(std::endian::native == std::endian::little && sizeof(double) == 8,
              "frames are raw little-endian 8-byte values");

constexpr std::size_t value_bytes = 8;

/// Number of values of a shape; throws when it is no shape or exceeds the limit.
std::size_t checked_size(const std::vector<std::int64_t>& shape, const std::string& name,
                         const CodecLimits& limits) {
  require<ProtocolError>(!shape.empty() && shape.size() <= 4,
                         "array \"{}\": expected 1 to 4 extents, found {}", name, shape.size());
  const std::size_t most = limits.max_frame_bytes / value_bytes;
  std::size_t size = 1;
  bool empty = false;
  for (const std::int64_t extent : shape) {
    require<ProtocolError>(extent >= 0, "array \"{}\": negative extent {}", name, extent);
    if (extent == 0) {
      empty = true;
      continue;
    }
    require<ProtocolError>(static_cast<std::uint64_t>(extent) <= most / size,
                           "array \"{}\" of shape [{}] exceeds the limit of {} bytes", name,
                           fmt::join(shape, ", "), limits.max_frame_bytes);
    size *= static_cast<std::size_t>(extent);
  }
  return empty ? 0 : size;
}

/// Nesting is bounded before parsing, so that nothing recursive can exhaust the stack.
void check_depth(std::string_view header, int max_depth) {
  int depth = 0;
  bool in_text = false;
  for (std::size_t i = 0; i < header.size(); ++i) {
    const char c = header[i];
    if (in_text) {
      if (c == '\\') ++i;
      if (c == '"') in_text = false;
    } else if (c == '"') {
      in_text = true;
    } else if (c == '{' || c == '[') {
      ++depth;
      require<ProtocolError>(depth <= max_depth, "header frame: nested deeper than {}", max_depth);
    } else if (c == '}' || c == ']') {
      --depth;
    }
  }
}

/// Replace all that is not printable ASCII by question marks: the text goes to logs and JSON files.
std::string printable(std::string text) {
  std::replace_if(
      text.begin(), text.end(), [](char c) { return c < ' ' || c > '~'; }, '?');
  return text;
}

Json parse_header(const std::string& frame, const CodecLimits& limits) {
  require<ProtocolError>(frame.size() <= limits.max_header_bytes,
                         "header frame of {} bytes exceeds the limit of {}", frame.size(),
                         limits.max_header_bytes);
  require<ProtocolError>(!frame.starts_with("\xEF\xBB\xBF"),
                         "header frame: starts with a byte order mark");
  // The parser takes a byte 0 for the end of the text, and ignores what follows.
  require<ProtocolError>(frame.find('\0') == std::string::npos,
                         "header frame is not JSON: holds a byte 0");
  check_depth(frame, limits.max_depth);
  try {
    Json header = Json::parse(frame);
    require<ProtocolError>(header.is_object(), "header frame: expected a JSON object, found " +
                                                   std::string(header.type_name()));
    return header;
  } catch (const Json::exception& problem) {
    throw ProtocolError("header frame is not JSON: " + printable(problem.what()));
  }
}

/// Name, dtype and shape of one entry of "arrays"; the values are left empty.
Array read_description(const Json& entry) {
  const auto text = [&entry](const char* key) {
    const auto found = entry.find(key);
    require<ProtocolError>(found != entry.end() && found->is_string(), [&] {
      return fmt::format("header frame: an array lacks the text \"{}\": {}", key, shortened(entry));
    });
    return found->get<std::string>();
  };
  require<ProtocolError>(entry.is_object(), [&] {
    return "header frame: an array's description is no object: " + shortened(entry);
  });
  Array array;
  array.name = text("name");
  const std::string dtype = text("dtype");
  require<ProtocolError>(dtype == "<f8" || dtype == "<i8",
                         "array \"{}\": expected dtype \"<f8\" or \"<i8\", found \"{}\"",
                         array.name, dtype);
  if (dtype == "<i8") array.values = std::vector<std::int64_t>();
  const auto shape = entry.find("shape");
  require<ProtocolError>(shape != entry.end() && shape->is_array() && shape->size() <= 4, [&] {
    return fmt::format("array \"{}\": expected a \"shape\" of 1 to 4 extents: {}", array.name,
                       shortened(entry));
  });
  for (const Json& extent : *shape) {
    const bool fits = extent.is_number_integer() &&
                      !(extent.is_number_unsigned() && extent.get<std::uint64_t>() > INT64_MAX);
    require<ProtocolError>(fits, [&] {
      return fmt::format("array \"{}\": expected integer extents, found {}", array.name,
                         shortened(*shape));
    });
    array.shape.push_back(extent.get<std::int64_t>());
  }
  return array;
}

void fill(Array& array, const std::string& frame, const CodecLimits& limits) {
  const std::size_t size = checked_size(array.shape, array.name, limits);
  require<ProtocolError>(frame.size() == size * value_bytes,
                         "array \"{}\" of shape [{}]: expected a frame of {} bytes, found {}",
                         array.name, fmt::join(array.shape, ", "), size * value_bytes,
                         frame.size());
  std::visit(
      [&](auto& values) {
        values.resize(size);
        if (size > 0) std::memcpy(values.data(), frame.data(), frame.size());
      },
      array.values);
}

void read_arrays(const Json& descriptions, std::span<const std::string> frames,
                 const CodecLimits& limits, Message& message) {
  require<ProtocolError>(descriptions.is_array(), "header frame: \"arrays\" is no list");
  require<ProtocolError>(descriptions.size() <= limits.max_arrays,
                         "header frame: {} arrays exceed the limit of {}", descriptions.size(),
                         limits.max_arrays);
  require<ProtocolError>(descriptions.size() == frames.size(),
                         "message \"{}\": header describes {} arrays, found {} frames",
                         message.type, descriptions.size(), frames.size());
  std::size_t payload = 0;
  for (const std::string& frame : frames) {
    require<ProtocolError>(frame.size() <= limits.max_payload_bytes - payload,
                           "message \"{}\" exceeds the limit of {} bytes", message.type,
                           limits.max_payload_bytes);
    payload += frame.size();
  }
  std::set<std::string> names;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    Array array = read_description(descriptions[i]);
    require<ProtocolError>(names.insert(array.name).second, "array \"{}\" is there twice",
                           array.name);
    fill(array, frames[i], limits);
    message.arrays.push_back(std::move(array));
  }
}

}  // namespace

EncodedMessage encode(const Message& message, const CodecLimits& limits) {
  EncodedMessage encoded;
  Json header = message.fields;
  header["type"] = message.type;
  header["sequence"] = message.sequence;
  require<ProtocolError>(message.arrays.size() <= limits.max_arrays,
                         "message \"{}\": {} arrays exceed the limit of {}", message.type,
                         message.arrays.size(), limits.max_arrays);
  std::size_t payload = 0;
  if (!message.arrays.empty()) header["arrays"] = Json::array();
  for (const Array& array : message.arrays) {
    const std::size_t size = checked_size(array.shape, array.name, limits);
    require<ProtocolError>(array.size() == size,
                           "message \"{}\", array \"{}\": shape [{}] but {} values", message.type,
                           array.name, fmt::join(array.shape, ", "), array.size());
    require<ProtocolError>(size * value_bytes <= limits.max_payload_bytes - payload,
                           "message \"{}\" exceeds the limit of {} bytes", message.type,
                           limits.max_payload_bytes);
    payload += size * value_bytes;
    const bool real = std::holds_alternative<std::vector<double>>(array.values);
    header["arrays"].push_back(
        {{"name", array.name}, {"dtype", real ? "<f8" : "<i8"}, {"shape", array.shape}});
    std::visit(
        [&](const auto& values) {
          encoded.payloads.emplace_back(reinterpret_cast<const char*>(values.data()),
                                        size * value_bytes);
        },
        array.values);
  }
  encoded.header = header.dump(-1, ' ', false, Json::error_handler_t::replace);
  require<ProtocolError>(encoded.header.size() <= limits.max_header_bytes,
                         "message \"{}\": header of {} bytes exceeds the limit of {}", message.type,
                         encoded.header.size(), limits.max_header_bytes);
  return encoded;
}

Message decode(std::span<const std::string> frames, const CodecLimits& limits) {
  require<ProtocolError>(!frames.empty(), "message without frames");
  Json header = parse_header(frames[0], limits);
  Message message;
  const auto type = header.find("type");
  require<ProtocolError>(type != header.end() && type->is_string(),
                         "header frame: expected a text \"type\"");
  message.type = type->get<std::string>();
  const auto sequence = header.find("sequence");
  require<ProtocolError>(sequence != header.end() && sequence->is_number_unsigned(),
                         "header frame: expected an integer \"sequence\" >= 0");
  message.sequence = sequence->get<std::uint64_t>();
  const auto arrays = header.find("arrays");
  read_arrays(arrays == header.end() ? Json(Json::array()) : *arrays, frames.subspan(1), limits,
              message);
  header.erase("type");
  header.erase("sequence");
  header.erase("arrays");
  message.fields = std::move(header);
  return message;
}

void require_finite(std::span<const double> values, std::size_t row_length,
                    const std::string& name) {
  const auto bad = std::find_if(values.begin(), values.end(),
                                [](double value) { return !std::isfinite(value); });
  if (bad == values.end()) return;
  const auto index = static_cast<std::size_t>(bad - values.begin());
  throw ProtocolError(fmt::format("\"{}\" is {} at vertex {}, component {}: values must be finite",
                                  name, *bad, index / row_length, index % row_length));
}

}  // namespace gabion
