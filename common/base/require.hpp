// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <fmt/core.h>

#include <concepts>
#include <string>
#include <utility>

#include "common/base/error.hpp"

namespace gabion {

/// Throw `ErrorType(message)` unless the condition holds.
template <class ErrorType = Error>
void require(bool condition, const std::string& message) {
  if (!condition) throw ErrorType(message);
}

/// As above, but the message is put together only when it is needed.
template <class ErrorType = Error, class First, class... Others>
void require(bool condition, fmt::format_string<First, Others...> message, First&& first,
             Others&&... others) {
  if (condition) return;
  throw ErrorType(
      fmt::format(message, std::forward<First>(first), std::forward<Others>(others)...));
}

/// As above, with a function that makes the message, where its parts are costly too.
template <class ErrorType = Error, std::invocable Message>
void require(bool condition, Message message) {
  if (!condition) throw ErrorType(message());
}

}  // namespace gabion
