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

/// Like require() with a message, which is put together here only when it is needed.
template <class ErrorType = Error, class First, class... Others>
void require(bool condition, fmt::format_string<First, Others...> message, First&& first,
             Others&&... others) {
  if (condition) return;
  throw ErrorType(
      fmt::format(message, std::forward<First>(first), std::forward<Others>(others)...));
}

/// Like require() with a message, which a function makes here: for messages with costly parts.
template <class ErrorType = Error, std::invocable Message>
void require(bool condition, Message message) {
  if (!condition) throw ErrorType(message());
}

}  // namespace gabion
