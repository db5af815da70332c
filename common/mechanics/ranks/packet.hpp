// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mpi.h>

#include <cstring>
#include <map>
#include <span>
#include <type_traits>
#include <utility>
#include <vector>

#include "common/base/require.hpp"

namespace gabion {

/// Numbers sent to another rank: taken in the order in which they were put.
class Packet {
 public:
  Packet() = default;
  explicit Packet(std::vector<char> bytes) : bytes_(std::move(bytes)) {}

  /// A number, or a vector or tensor of fixed size.
  template <class Value>
  void put(const Value& value) {
    const char* const first = reinterpret_cast<const char*>(numbers_of(value));
    bytes_.insert(bytes_.end(), first, first + size_of<Value>());
  }
  template <class Number>
  void put_all(std::span<const Number> numbers) {
    const char* const first = reinterpret_cast<const char*>(numbers.data());
    bytes_.insert(bytes_.end(), first, first + numbers.size_bytes());
  }
  template <class Value>
  Value take() {
    constexpr std::size_t size = size_of<Value>();
    require(next_ + size <= bytes_.size(), "a message of another rank is too short");
    Value value;
    std::memcpy(numbers_of(value), bytes_.data() + next_, size);
    next_ += size;
    return value;
  }
  template <class Number>
  void take_all(std::vector<Number>& numbers) {
    const std::size_t size = numbers.size() * sizeof(Number);
    require(next_ + size <= bytes_.size(), "a message of another rank is too short");
    if (size > 0) std::memcpy(numbers.data(), bytes_.data() + next_, size);
    next_ += size;
  }
  bool empty() const { return next_ == bytes_.size(); }
  std::span<const char> bytes() const { return bytes_; }

 private:
  template <class Value>
  static constexpr std::size_t size_of() {
    if constexpr (std::is_arithmetic_v<Value>) {
      return sizeof(Value);
    } else {
      return Value::SizeAtCompileTime * sizeof(typename Value::Scalar);
    }
  }
  template <class Value>
  static auto* numbers_of(Value& value) {
    if constexpr (std::is_arithmetic_v<std::remove_const_t<Value>>) {
      return &value;
    } else {
      return value.data();
    }
  }

  std::vector<char> bytes_;
  std::size_t next_ = 0;
};

/// Packets by the rank that they go to, or come from.
using Packets = std::map<int, Packet>;

/// Send packets to other ranks. Only ranks with a packet for each other exchange a message.
/// @returns those for this rank
/// @note Collective.
Packets send_packets(MPI_Comm comm, const Packets& out);

}  // namespace gabion
