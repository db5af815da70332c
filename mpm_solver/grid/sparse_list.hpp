// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

namespace gabion::mpm {

/// Values of 0 .. size - 1 of which all but few are the same: the others are kept in blocks of 64,
/// so that memory and time go with those. For fields of the cells or nodes of a grid of which the
/// soil reaches a small part.
template <class Value>
class SparseList {
 public:
  SparseList() = default;
  SparseList(std::size_t size, const Value& common) { assign(size, common); }

  /// `size` values that are all `common`. @note Takes time in proportion to the values that were
  /// set, where size stays.
  void assign(std::size_t size, const Value& common) {
    for (const std::size_t block : used_) starts_[block] = 0;
    used_.clear();
    values_.assign(length, common);
    starts_.resize((size + length - 1) / length, 0);
  }
  const Value& operator[](std::size_t i) const { return values_[starts_[i / length] + i % length]; }
  /// Reference through which a value is set. @note May move the other values.
  Value& at(std::size_t i) {
    std::uint32_t& start = starts_[i / length];
    if (start == 0) {
      start = static_cast<std::uint32_t>(values_.size());
      used_.push_back(i / length);
      values_.resize(values_.size() + length, Value(values_.front()));
    }
    return values_[start + i % length];
  }
  /// visit(i, value) for those that differ from the common value, ascending; it may change them.
  template <class Visit>
  void for_each(const Visit& visit) {
    std::sort(used_.begin(), used_.end());
    for (const std::size_t block : used_) {
      for (std::size_t k = 0; k < length; ++k) {
        Value& value = values_[starts_[block] + k];
        if (value != values_.front()) visit(block * length + k, value);
      }
    }
  }
  std::size_t bytes() const {
    return starts_.capacity() * sizeof(starts_[0]) + used_.capacity() * sizeof(used_[0]) +
           values_.capacity() * sizeof(Value);
  }

 private:
  static constexpr std::size_t length = 64;
  std::vector<std::uint32_t> starts_;  // of each block in values_; 0: all its values are common
  std::vector<std::size_t> used_;      // blocks with values of their own
  std::vector<Value> values_;          // the first block has the common value
};

}  // namespace gabion::mpm
