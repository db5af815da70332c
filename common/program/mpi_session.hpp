// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mpi.h>

#include <string>
#include <vector>

namespace gabion {

/// MPI for one program of a multi-program launch
/// (`mpirun -n 1 coupler … : -n 2 mpm_solver … : -n 1 fem_solver …`), where all programs share one
/// world. Gives each program a communicator of its own. The only place that names the world.
class MpiSession {
 public:
  /// Starts MPI. Collective over the world.
  /// @param program  name of this program, such as "coupler"
  MpiSession(int& argc, char**& argv, const std::string& program);
  ~MpiSession();
  MpiSession(const MpiSession&) = delete;
  MpiSession& operator=(const MpiSession&) = delete;
  MpiSession(MpiSession&&) = delete;
  MpiSession& operator=(MpiSession&&) = delete;

  MPI_Comm comm() const { return comm_; }  ///< this program's ranks
  int rank() const { return rank_; }
  int size() const { return size_; }
  bool is_root() const { return rank_ == 0; }
  /// Whether the launch has no other process: nobody else must be taken down.
  bool is_only_process() const { return programs_.size() == 1; }

  /// Whether a program of this name is part of the launch.
  bool launched_with(const std::string& program) const;

  /// Send a text from the first rank of `program` to everybody. Collective over the world.
  std::string share(const std::string& program, const std::string& text) const;

  /// Take down the whole launch with this exit code. Does not return.
  [[noreturn]] static void abort(int exit_code);

  /// End this process only: another one of the launch has failed, or the launcher's signal came.
  /// The launch gets the exit code of the first process that is lost, so the one that failed needs
  /// a head start. Does not return.
  /// @param head_start  whole seconds, cut short when the launcher's signal comes
  [[noreturn]] static void leave(int exit_code, int head_start);

 private:
  MPI_Comm comm_ = MPI_COMM_NULL;
  int rank_ = 0;
  int size_ = 1;
  std::vector<std::string> programs_;  // program of each rank of the world
  std::string own_memory_;             // name that this process gave to its shared memory
};

}  // namespace gabion
