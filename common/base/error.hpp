// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <stdexcept>
#include <string>
#include <utility>

namespace gabion {

/// A failure caused by the user, a file, a peer or the physics of a run; our own bugs are
/// `assert`s. The message says what was expected, what was found and where.
class Error : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
  /// Exit code of a program that ends with this error; 1 is for a check that found faults.
  virtual int exit_code() const { return 4; }
};

/// Wrong input: the message carries file, JSON pointer, what was found and what is allowed.
class ConfigError : public Error {
 public:
  using Error::Error;
  int exit_code() const override { return 2; }
};

/// A step could not be solved. The accepted state is untouched: the step may be repeated with a
/// smaller dt.
class ConvergenceError : public Error {
 public:
  /// @param cause  word under which failures are counted, such as "iteration_limit"
  explicit ConvergenceError(const std::string& message, std::string cause = "other")
      : Error(message), cause_(std::move(cause)) {}
  int exit_code() const override { return 3; }
  const std::string& cause() const { return cause_; }

 private:
  std::string cause_;
};

/// A peer was lost, refused, late, or spoke something that is not the protocol.
class ProtocolError : public Error {
 public:
  using Error::Error;
  int exit_code() const override { return 4; }
};

}  // namespace gabion
