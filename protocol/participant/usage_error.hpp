// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "common/base/error.hpp"

namespace gabion {

/// A call in the wrong order, or with values that do not fit. The message says what is allowed.
class UsageError : public Error {
 public:
  using Error::Error;
  int exit_code() const override { return 2; }
};

}  // namespace gabion
