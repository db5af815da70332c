// SPDX-License-Identifier: BSD-3-Clause
#include "protocol/channel/strangers.hpp"

#include "common/base/log.hpp"

namespace gabion {
namespace {

constexpr std::size_t most_routes = 4096;  // remembered: more than a process has descriptors
constexpr int most_named = 10;
constexpr double count_period = 60;  // [s] between two counts in the log

}  // namespace

Strangers::~Strangers() {
  say_count();
}

bool Strangers::drops(const std::string& route) {
  if (!routes_.contains(route)) return false;
  ++count_;
  if (since_said_.seconds() > count_period) say_count();
  return true;
}

void Strangers::refuse(const std::string& route, const std::string& what) {
  ++count_;
  if (routes_.insert(route).second) oldest_.push_back(route);
  if (oldest_.size() > most_routes) {
    routes_.erase(oldest_.front());
    oldest_.pop_front();
  }
  if (named_ < most_named) {
    ++named_;
    ++said_;
    log::warn("{}", what);
  } else if (since_said_.seconds() > count_period) {
    say_count();
  }
}

void Strangers::say_count() {
  if (count_ > said_) {
    log::warn("dropped {} more messages from senders that are no participants", count_ - said_);
  }
  said_ = count_;
  since_said_ = Stopwatch();
}

}  // namespace gabion
