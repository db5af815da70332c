// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace gabion::mpm {

/// Numbers of keys of n integers each: 0, 1, ... in the order in which the keys were added.
template <std::size_t n>
class IndexTable {
 public:
  using Key = std::array<std::int64_t, n>;

  std::int32_t size() const { return size_; }
  void clear() {
    slots_.clear();
    size_ = 0;
  }

  /// Number of a key; -1: it was not added.
  std::int32_t find(const Key& key) const {
    return slots_.empty() ? -1 : slots_[slot_of(key)].number;
  }

  /// Number of a key, which is added where it is missing.
  std::int32_t add(const Key& key) {
    if (2 * static_cast<std::size_t>(size_ + 1) > slots_.size()) grow();
    Slot& slot = slots_[slot_of(key)];
    if (slot.number < 0) slot = {key, size_++};
    return slot.number;
  }

 private:
  struct Slot {
    Key key{};
    std::int32_t number = -1;
  };

  static bool same(const Key& a, const Key& b) {
    std::int64_t differ = 0;
    for (std::size_t k = 0; k < n; ++k) differ |= a[k] ^ b[k];
    return differ == 0;
  }

  // Slot in which the key is, or would be added. @pre a slot is empty
  std::size_t slot_of(const Key& key) const {
    std::size_t hash = 0;
    for (const std::int64_t k : key) {
      hash = (hash ^ static_cast<std::size_t>(k)) * std::size_t{0x9E3779B97F4A7C15};
    }
    const std::size_t mask = slots_.size() - 1;
    std::size_t slot = (hash ^ (hash >> 29)) & mask;
    while (slots_[slot].number >= 0 && !same(slots_[slot].key, key)) slot = (slot + 1) & mask;
    return slot;
  }

  void grow() {
    std::vector<Slot> before(slots_.empty() ? 16 : 2 * slots_.size());
    before.swap(slots_);
    for (const Slot& slot : before) {
      if (slot.number >= 0) slots_[slot_of(slot.key)] = slot;
    }
  }

  std::vector<Slot> slots_;  // a power of 2
  std::int32_t size_ = 0;
};

}  // namespace gabion::mpm
