// SPDX-License-Identifier: BSD-3-Clause
#include "coupler/mapping/interface_layout.hpp"

#include <algorithm>

#include "common/base/require.hpp"

namespace gabion {

InterfaceValues InterfaceLayout::values_in(const Eigen::VectorXd& all) const {
  InterfaceValues values;
  for (const InterfacePlace& place : places_) {
    const double* begin = all.data() + place.begin;
    values[place.name].assign(begin, begin + place.size);
  }
  return values;
}

void InterfaceLayout::put(const InterfaceValues& sent, Eigen::VectorXd& all) const {
  for (const InterfacePlace& place : places_) {
    const auto found = sent.find(place.name);
    require(found != sent.end(), "participant \"{}\" sent nothing for interface \"{}\"",
            participant_, place.name);
    require(std::ssize(found->second) == place.size,
            "participant \"{}\" sent {} values for interface \"{}\", expected {}", participant_,
            found->second.size(), place.name, place.size);
    std::copy(found->second.begin(), found->second.end(), all.data() + place.begin);
  }
}

void InterfaceLayout::fill(const std::string& interface, double value, Eigen::VectorXd& all) const {
  for (const InterfacePlace& place : places_) {
    if (place.name == interface) all.segment(place.begin, place.size).setConstant(value);
  }
}

bool InterfaceLayout::is_zero_in(const Eigen::VectorXd& all) const {
  return std::all_of(places_.begin(), places_.end(), [&](const InterfacePlace& place) {
    return all.segment(place.begin, place.size).isZero(0);
  });
}

}  // namespace gabion
