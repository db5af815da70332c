// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "common/run/solver.hpp"

namespace gabion {

/// Range of one interface in a vector over all interfaces of a side.
struct InterfacePlace {
  std::string name;
  Eigen::Index begin = 0;
  Eigen::Index size = 0;  ///< num_vertices x dim
};

/// The interfaces of one participant in the vectors of its side. Here, and nowhere else in the
/// coupler, values by name become entries of a vector, and back.
class InterfaceLayout {
 public:
  InterfaceLayout(std::string participant, std::vector<InterfacePlace> places)
      : participant_(std::move(participant)), places_(std::move(places)) {}

  const std::string& participant() const { return participant_; }
  /// This participant's share of a vector.
  InterfaceValues values_in(const Eigen::VectorXd& all) const;
  /// Put the values that this participant sent in their place; the rest of the vector stays.
  /// @throws Error  an interface is missing or has another number of values
  void put(const InterfaceValues& sent, Eigen::VectorXd& all) const;
  /// Set all entries of one interface of this participant.
  void fill(const std::string& interface, double value, Eigen::VectorXd& all) const;
  /// Whether all values of this participant are zero.
  bool is_zero_in(const Eigen::VectorXd& all) const;

 private:
  std::string participant_;
  std::vector<InterfacePlace> places_;
};

}  // namespace gabion
