// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "protocol/wire/message.hpp"

namespace gabion {

/// Limits of what a receiver accepts, checked before anything of that size is allocated.
struct CodecLimits {
  std::size_t max_header_bytes = std::size_t{1} << 20;
  std::size_t max_arrays = 256;
  std::size_t max_frame_bytes = std::size_t{1} << 30;    ///< size of one array
  std::size_t max_payload_bytes = std::size_t{1} << 31;  ///< size of all arrays of a message
  int max_depth = 32;                                    ///< nesting of the JSON header
};

/// A message as frames: the header, and views of the arrays' memory.
struct EncodedMessage {
  std::string header;
  std::vector<std::string_view> payloads;  ///< valid while the message lives and is not changed
};

/// @throws ProtocolError  a limit is exceeded, or a shape does not fit its values
EncodedMessage encode(const Message& message, const CodecLimits& limits = {});

/// Frames back to a message. For any bytes either the message is whole, or this throws. Memory used
/// beside the frames: at most 64 times the header's bytes, plus the payload's bytes.
///
/// @param frames  header first, then one frame an array
/// @throws ProtocolError  says which frame is wrong, what was expected and found
Message decode(std::span<const std::string> frames, const CodecLimits& limits = {});

/// @throws ProtocolError  naming array, row, column and value of the first non-finite entry
/// @param row_length  values per row (vertex)
void require_finite(std::span<const double> values, std::size_t row_length,
                    const std::string& name);

}  // namespace gabion
