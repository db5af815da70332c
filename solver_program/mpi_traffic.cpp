// SPDX-License-Identifier: BSD-3-Clause
#include "solver_program/mpi_traffic.hpp"

#include <dlfcn.h>

namespace gabion {

MpiTraffic& MpiTraffic::operator+=(const MpiTraffic& other) {
  messages += other.messages;
  message_bytes += other.message_bytes;
  collectives += other.collectives;
  collective_bytes += other.collective_bytes;
  waiting_seconds += other.waiting_seconds;
  return *this;
}

MpiTraffic operator-(MpiTraffic a, const MpiTraffic& b) {
  a.messages -= b.messages;
  a.message_bytes -= b.message_bytes;
  a.collectives -= b.collectives;
  a.collective_bytes -= b.collective_bytes;
  a.waiting_seconds -= b.waiting_seconds;
  return a;
}

std::optional<MpiTraffic> mpi_traffic() {
  using Counter = void (*)(MpiTraffic*);
  static const auto counter = reinterpret_cast<Counter>(dlsym(RTLD_DEFAULT, "gabion_mpi_traffic"));
  if (counter == nullptr) return std::nullopt;
  MpiTraffic so_far;
  counter(&so_far);
  return so_far;
}

}  // namespace gabion
