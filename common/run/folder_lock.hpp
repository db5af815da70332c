// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "common/base/descriptor.hpp"
#include "common/base/process.hpp"

namespace gabion {

/// Who writes into a folder, as a lock file says.
struct LockOwner {
  std::string program;
  ProcessIdentity process;
  std::string since;  ///< UTC
  std::string file;   ///< file that says so
};

/// Owners that the lock files of a folder and of the folders in it name, but for those that are
/// surely gone. Files that nobody signed, or that their owner cleared at its end, name nobody.
std::vector<LockOwner> owners_that_may_live(const std::filesystem::path& folder);

/// A lock on a folder, in the file `.gabion_lock` there. It is one of flock(2): whatever ends the
/// process, the system releases it. Who signs it also names program, host, process id and start
/// in the file, for others to read, and clears that at its end. The file stays.
///
/// Nobody waits: a folder that is in use is refused at once.
class FolderLock {
 public:
  enum class Kind {
    alone,   ///< nobody else has a lock on the folder: it may be moved
    beside,  ///< others may write there too: it must not be moved
  };

  /// @param folder  must exist
  /// @throws ConfigError  it is in use: by whom, since when, and which file says so; where locks
  ///     of the file system may end at the machine, an owner on another one that cannot be asked
  /// @throws Error  the file cannot be written
  FolderLock(const std::filesystem::path& folder, Kind kind);
  ~FolderLock();
  FolderLock(FolderLock&& other) noexcept = default;
  FolderLock& operator=(FolderLock&& other) = delete;
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;

  /// Name this process as the owner. @throws Error  the file cannot be written
  void sign(const std::string& program);
  /// Change the lock from `alone` to `beside`. @throws ConfigError  somebody else was faster
  void share();

 private:
  std::filesystem::path folder_;
  Descriptor file_;
  Kind kind_;
  bool is_signed_ = false;
};

}  // namespace gabion
