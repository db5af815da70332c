// SPDX-License-Identifier: BSD-3-Clause
#include "common/program/mpi_session.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <fstream>
#include <thread>

#include "common/base/require.hpp"

namespace gabion {

namespace {
constexpr int name_length = 32;

/// Open MPI listens on all network interfaces even when its processes share one machine, which then
/// need no network. For a process that was started without mpirun it starts a daemon, in case that
/// the process wants to start others; once in some thousand starts both wait for each other for
/// ever (open-mpi/ompi issue 3818). Without the daemon, all such processes share one folder of
/// temporary files, which one removes while another starts; a process alone needs none. A user's
/// own choices stand.
void start_only_what_is_needed() {
  const char* all = std::getenv("OMPI_COMM_WORLD_SIZE");
  const char* here = std::getenv("OMPI_COMM_WORLD_LOCAL_SIZE");
  const bool alone = all == nullptr && here == nullptr;
  if (alone) {
    setenv("OMPI_MCA_ess_singleton_isolated", "1", /*overwrite=*/0);
    setenv("OMPI_MCA_orte_create_session_dirs", "0", /*overwrite=*/0);
  }
  if (alone || (all != nullptr && here != nullptr && std::strcmp(all, here) == 0)) {
    setenv("OMPI_MCA_btl", "^tcp,ofi", /*overwrite=*/0);
  }
}

/// Open MPI's shared memory has names in /dev/shm, which mpirun removes; one that is killed leaves
/// them. All processes have opened it by now, and need the names no more.
/// @note  After a barrier.
/// @returns  the name of this process's own memory; empty: it has none
std::string remove_names_of_shared_memory(int world_rank) {
  const std::string end = fmt::format(".{}", world_rank);
  std::string own;
  std::ifstream maps("/proc/self/maps");
  for (std::string line; std::getline(maps, line);) {
    for (const char* start : {"/dev/shm/vader_segment.", "/dev/shm/sm_segment."}) {  // of 4, of 5
      const std::size_t name = line.find(start);
      if (name == std::string::npos) continue;
      const std::string memory = line.substr(name, line.find(" (deleted)", name) - name);
      unlink(memory.c_str());
      if (memory.ends_with(end)) own = memory;
    }
  }
  return own;
}
}  // namespace

MpiSession::MpiSession(int& argc, char**& argv, const std::string& program) {
  start_only_what_is_needed();
  MPI_Init(&argc, &argv);
  int world_size = 1;
  int world_rank = 0;
  MPI_Comm_size(MPI_COMM_WORLD, &world_size);
  MPI_Comm_rank(MPI_COMM_WORLD, &world_rank);

  std::array<char, name_length> own{};
  std::copy_n(program.begin(), std::min<std::size_t>(program.size(), name_length - 1), own.begin());
  std::vector<char> all(static_cast<std::size_t>(world_size) * name_length);
  MPI_Allgather(own.data(), name_length, MPI_CHAR, all.data(), name_length, MPI_CHAR,
                MPI_COMM_WORLD);
  own_memory_ = remove_names_of_shared_memory(world_rank);
  for (int r = 0; r < world_size; ++r) programs_.emplace_back(all.data() + r * name_length);

  const auto color = std::find(programs_.begin(), programs_.end(), program) - programs_.begin();
  MPI_Comm_split(MPI_COMM_WORLD, static_cast<int>(color), world_rank, &comm_);
  MPI_Comm_rank(comm_, &rank_);
  MPI_Comm_size(comm_, &size_);
}

MpiSession::~MpiSession() {
  // MPI_Finalize removes the name of its memory, and complains where there is none.
  if (!own_memory_.empty()) std::ofstream(own_memory_, std::ios::app).flush();
  MPI_Comm_free(&comm_);
  MPI_Finalize();
}

bool MpiSession::launched_with(const std::string& program) const {
  return std::find(programs_.begin(), programs_.end(), program) != programs_.end();
}

std::string MpiSession::share(const std::string& program, const std::string& text) const {
  const auto found = std::find(programs_.begin(), programs_.end(), program);
  require(found != programs_.end(), "the launch has no program \"" + program + "\"");
  const int root = static_cast<int>(found - programs_.begin());
  int length = static_cast<int>(text.size());
  MPI_Bcast(&length, 1, MPI_INT, root, MPI_COMM_WORLD);
  std::string result = text;
  result.resize(static_cast<std::size_t>(length));
  MPI_Bcast(result.data(), length, MPI_CHAR, root, MPI_COMM_WORLD);
  return result;
}

void MpiSession::abort(int exit_code) {
  // The launcher drops what it has not read from its programs by then.
  std::this_thread::sleep_for(std::chrono::milliseconds(100));
  MPI_Abort(MPI_COMM_WORLD, exit_code);
  std::_Exit(exit_code);
}

void MpiSession::leave(int exit_code, int head_start) {
  sigset_t from_launcher;
  sigemptyset(&from_launcher);
  sigaddset(&from_launcher, SIGTERM);
  sigprocmask(SIG_BLOCK, &from_launcher, nullptr);
  const timespec patience = {head_start, 0};
  sigtimedwait(&from_launcher, nullptr, &patience);
  // The process ends without MPI_Finalize, so that the launcher takes it for a failure. Many
  // simultaneous calls of MPI_Abort make Open MPI 4.1's mpirun crash now and then.
  std::_Exit(exit_code);
}

}  // namespace gabion
