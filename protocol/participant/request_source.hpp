// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "protocol/wire/message.hpp"

namespace gabion {

/// Source of the coupler's requests, and destination of the answers.
class RequestSource {
 public:
  virtual ~RequestSource() = default;

  /// Wait for the next request.
  /// @param[out] frames  the bytes it came in, header first; null: nobody asks
  virtual Message next_request(std::vector<std::string>* frames) = 0;
  /// Answer the request that next_request() gave last.
  virtual void reply(Message message) = 0;
};

}  // namespace gabion
