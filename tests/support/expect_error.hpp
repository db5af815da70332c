// SPDX-License-Identifier: BSD-3-Clause
// The text of an error, as all tests check it.
#pragma once

#include <gtest/gtest.h>

#include <string>
#include <string_view>
#include <typeinfo>
#include <vector>

#include "common/base/error.hpp"

namespace gabion::test {

/// Text of the `Expected` that `action` throws. No error, or one of exactly another type, fails the
/// test and gives "".
template <class Expected, class Action>
std::string error_of(const Action& action) {
  try {
    action();
  } catch (const Expected& error) {
    EXPECT_EQ(typeid(error).name(), typeid(Expected).name()) << error.what();
    return error.what();
  } catch (const std::exception& error) {
    ADD_FAILURE() << "found an error of another type: " << error.what();
    return "";
  }
  ADD_FAILURE() << "found no error";
  return "";
}

/// Each part is in the text.
inline void expect_parts(const std::string& text, const std::vector<std::string_view>& parts) {
  for (const std::string_view part : parts) {
    EXPECT_NE(text.find(part), std::string::npos) << "\"" << part << "\" is not in: " << text;
  }
}

/// `action` throws an `Expected` (ConfigError, ...) whose text has each of these parts: at least one.
template <class Expected, class Action>
void expect_error(const Action& action, const std::vector<std::string_view>& parts) {
  EXPECT_FALSE(parts.empty()) << "say what the error has to say";
  expect_parts(error_of<Expected>(action), parts);
}

}  // namespace gabion::test
