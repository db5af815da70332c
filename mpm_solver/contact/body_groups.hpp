// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "mpm_solver/contact/contact_law.hpp"

namespace gabion::mpm {

/// Contact between the bodies of two groups. M is the smaller P-wave modulus of the two, h the mean
/// cell size.
struct GroupPair {
  std::int32_t first = 0, second = 0;  ///< groups, first < second
  ContactMode mode = ContactMode::contact;
  double friction = -1;             ///< as in ContactLaw
  double penalty_factor = 10;       ///< traction at a depth d: penalty_factor M (d / h)^2
  double tangential_factor = 0.25;  ///< stiffness: tangential_factor M / h
};

/// Bodies of one group share the nodes of the grid; those of different groups have nodes of their
/// own and meet by contact.
struct BodyGroups {
  std::vector<std::string> names;     ///< of the groups; empty: all bodies share the nodes
  std::vector<std::int32_t> of_body;  ///< group of each body
  std::vector<GroupPair> pairs;       ///< each pair of groups once
  std::string where;                  ///< place in the config, for messages

  bool any() const { return !names.empty(); }
  /// Names of a pair for columns and messages.
  std::string text_of(std::size_t pair) const {
    return names[pairs[pair].first] + "." + names[pairs[pair].second];
  }
};

}  // namespace gabion::mpm
