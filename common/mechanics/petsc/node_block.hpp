// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstring>

#include <Eigen/Core>

namespace gabion {

/// Block that couples the unknowns of one node to those of another, column-major.
template <int block_size>
using NodeBlock = Eigen::Matrix<double, block_size, block_size>;

/// The entries of a NodeBlock as one vector of the machine: sums of blocks are most of an assembly.
/// The entry (a, b) of rows() of x is x_a, that of columns() x_b; products are entry by entry.
template <int block_size>
class BlockVector;

/// Four doubles, which the compiler spreads over what registers there are.
template <>
class BlockVector<2> {
 public:
  static constexpr int num_entries = 4;

  void load(const double* entries) { std::memcpy(&v_, entries, sizeof v_); }
  void store(double* entries) const { std::memcpy(entries, &v_, sizeof v_); }
  static BlockVector zero() { return BlockVector(Four{}); }
  static BlockVector rows(const double* x) { return BlockVector(Four{x[0], x[1], x[0], x[1]}); }
  static BlockVector columns(const double* x) { return BlockVector(Four{x[0], x[0], x[1], x[1]}); }
  BlockVector operator*(double s) const { return BlockVector(v_ * s); }
  BlockVector operator*(const BlockVector& y) const { return BlockVector(v_ * y.v_); }
  BlockVector& operator+=(const BlockVector& y) {
    v_ += y.v_;
    return *this;
  }
  BlockVector() = default;

 private:
  using Four = double __attribute__((vector_size(num_entries * sizeof(double))));
  explicit BlockVector(const Four& v) : v_(v) {}
  Four v_;
};

/// Nine doubles: twice four and one.
template <>
class BlockVector<3> {
 public:
  static constexpr int num_entries = 9;

  void load(const double* entries) {
    std::memcpy(&low_, entries, sizeof low_);
    std::memcpy(&high_, entries + 4, sizeof high_);
    last_ = entries[8];
  }
  void store(double* entries) const {
    std::memcpy(entries, &low_, sizeof low_);
    std::memcpy(entries + 4, &high_, sizeof high_);
    entries[8] = last_;
  }
  static BlockVector zero() { return {Four{}, Four{}, 0}; }
  static BlockVector rows(const double* x) {
    return {Four{x[0], x[1], x[2], x[0]}, Four{x[1], x[2], x[0], x[1]}, x[2]};
  }
  static BlockVector columns(const double* x) {
    return {Four{x[0], x[0], x[0], x[1]}, Four{x[1], x[1], x[2], x[2]}, x[2]};
  }
  BlockVector operator*(double s) const { return {low_ * s, high_ * s, last_ * s}; }
  BlockVector operator*(const BlockVector& y) const {
    return {low_ * y.low_, high_ * y.high_, last_ * y.last_};
  }
  BlockVector& operator+=(const BlockVector& y) {
    low_ += y.low_;
    high_ += y.high_;
    last_ += y.last_;
    return *this;
  }
  BlockVector() = default;

 private:
  using Four = double __attribute__((vector_size(4 * sizeof(double))));
  BlockVector(const Four& low, const Four& high, double last)
      : low_(low), high_(high), last_(last) {}
  Four low_, high_;
  double last_;
};

}  // namespace gabion
