// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <thread>

#include "common/base/error.hpp"

namespace gabion {

/// The process was asked to end by a signal.
class Interrupted : public Error {
 public:
  explicit Interrupted(int signal);
  int exit_code() const override { return 128 + signal_; }

 private:
  int signal_;
};

namespace interrupt {

/// SIGINT and SIGTERM only set a flag, which every wait of the protocol looks at. A second signal
/// of the same kind ends the process at once.
void install();

/// The signal that came first, 0 = none. Long computations may look at it between their steps.
int requested();

/// [s] after a signal in which a run may still write a checkpoint: what mpirun leaves until it
/// kills (OMPI_MCA_odls_base_sigkill_timeout, 1 s by default), less the time for the last words.
double patience();

/// @throws Interrupted  when a signal came
void check();

/// A thread that gets no signals: they are for the thread that waits.
std::thread quiet_thread(std::function<void()> work);

/// Forget a signal that came.
void clear();

}  // namespace interrupt
}  // namespace gabion
