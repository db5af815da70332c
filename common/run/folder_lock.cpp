// SPDX-License-Identifier: BSD-3-Clause
#include "common/run/folder_lock.hpp"

#include <fcntl.h>
#include <fmt/chrono.h>
#include <fmt/format.h>
#include <linux/magic.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <sys/vfs.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <ctime>
#include <fstream>

#include "common/base/json.hpp"
#include "common/base/require.hpp"

namespace gabion {

namespace fs = std::filesystem;

namespace {

constexpr const char* lock_name = ".gabion_lock";  // scripts add their own name
constexpr int most_tries = 100;                    // while others move the folder away

/// Lock files in a folder and in the folders in it.
std::vector<fs::path> lock_files(const fs::path& folder) {
  std::vector<fs::path> files;
  std::error_code error;
  const auto collect = [&](const fs::path& place) {
    for (const auto& entry : fs::directory_iterator(place, error)) {
      if (entry.path().filename().string().starts_with(lock_name)) files.push_back(entry.path());
    }
  };
  collect(folder);
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    if (entry.is_directory(error)) collect(entry.path());
  }
  return files;
}

/// Whether the file names an owner. Text that is not a signature comes from a write cut short.
bool read_owner(const fs::path& file, LockOwner& owner) {
  std::ifstream in(file);
  const Json text = Json::parse(in, nullptr, /*allow_exceptions=*/false);
  if (!text.is_object()) return false;
  try {
    owner = {.program = text.at("program"),
             .process = {.host = text.at("host"),
                         .pid = text.at("pid"),
                         .start_time = text.at("start_time")},
             .since = text.at("since"),
             .file = file.string()};
    return true;
  } catch (const Json::exception&) {
    return false;
  }
}

/// The name of the machine in ProcessIdentity::host.
std::string machine_of(const LockOwner& owner) {
  const std::string& host = owner.process.host;
  return host.empty() ? "an unknown machine" : host.substr(0, host.find('/'));
}

std::string in_use(const fs::path& folder, const std::vector<LockOwner>& owners) {
  const std::string shortest_exit = "wait until it ends, or give another folder with --output";
  if (owners.empty()) {
    return fmt::format("output folder {}: in use by another program, as {} tells; {}",
                       folder.string(), (folder / lock_name).string(), shortest_exit);
  }
  // An owner that is known to live is the better answer.
  const auto alive = std::ranges::find_if(owners, [](const LockOwner& owner) {
    return look_up(owner.process) != ProcessState::unknown;
  });
  const LockOwner& owner = alive == owners.end() ? owners.front() : *alive;
  const std::string who =
      fmt::format("{} (pid {} on {}, since {}; {})", owner.program, owner.process.pid,
                  machine_of(owner), owner.since, owner.file);
  if (alive == owners.end()) {
    return fmt::format(
        "output folder {}: may be in use by {}, which cannot be asked from here; if it runs no "
        "more, remove that file, or give another folder with --output",
        folder.string(), who);
  }
  return fmt::format("output folder {}: in use by {}; {}", folder.string(), who, shortest_exit);
}

/// Whether all that can open the file share one kernel, so that its locks are known to all.
bool is_local(int file) {
  constexpr long zfs_magic = 0x2FC12FC1;
  constexpr std::array<long, 7> local = {EXT4_SUPER_MAGIC,     XFS_SUPER_MAGIC, BTRFS_SUPER_MAGIC,
                                         F2FS_SUPER_MAGIC,     TMPFS_MAGIC,     zfs_magic,
                                         OVERLAYFS_SUPER_MAGIC};
  struct statfs system = {};
  return fstatfs(file, &system) == 0 &&
         std::ranges::find(local, static_cast<long>(system.f_type)) != local.end();
}

bool is_same_file(int file, const fs::path& path) {
  struct stat opened = {};
  struct stat named = {};
  return fstat(file, &opened) == 0 && stat(path.c_str(), &named) == 0 &&
         opened.st_dev == named.st_dev && opened.st_ino == named.st_ino;
}

/// Take the lock at once. @returns whether the file system has such locks
bool take_lock(int file, int operation, const fs::path& folder) {
  if (flock(file, operation | LOCK_NB) == 0) return true;
  require<ConfigError>(errno != EWOULDBLOCK,
                       [&] { return in_use(folder, owners_that_may_live(folder)); });
  return false;
}

}  // namespace

std::vector<LockOwner> owners_that_may_live(const fs::path& folder) {
  std::vector<LockOwner> owners;
  for (const fs::path& file : lock_files(folder)) {
    LockOwner owner;
    if (read_owner(file, owner) && look_up(owner.process) != ProcessState::gone) {
      owners.push_back(owner);
    }
  }
  return owners;
}

FolderLock::FolderLock(const fs::path& folder, Kind kind) : folder_(folder), kind_(kind) {
  const fs::path path = folder / lock_name;
  bool is_held = false;
  for (int tries = 0; tries < most_tries; ++tries) {
    file_ = Descriptor(open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0666));
    require(file_.is_open(), "{}: cannot be written: {}", path.string(), std::strerror(errno));
    is_held = take_lock(file_.number(), kind == Kind::alone ? LOCK_EX : LOCK_SH, folder);
    if (is_same_file(file_.number(), path)) break;  // else the folder was moved in between
  }
  if (kind == Kind::beside || (is_held && is_local(file_.number()))) return;
  const auto owners = owners_that_may_live(folder);
  require<ConfigError>(owners.empty(), [&] { return in_use(folder, owners); });
}

FolderLock::~FolderLock() {
  if (!file_.is_open() || (kind_ == Kind::beside && !is_signed_)) return;
  // A signature that stays names a process that is gone.
  [[maybe_unused]] const int cleared = ftruncate(file_.number(), 0);
}

void FolderLock::sign(const std::string& program) {
  const ProcessIdentity self = this_process();
  const Json owner = {
      {"program", program},
      {"host", self.host},
      {"pid", self.pid},
      {"start_time", self.start_time},
      {"since", fmt::format("{:%Y-%m-%d %H:%M:%S} UTC", fmt::gmtime(std::time(nullptr)))}};
  const std::string text = owner.dump() + "\n";
  is_signed_ = true;
  const bool written = ftruncate(file_.number(), 0) == 0 &&
                       pwrite(file_.number(), text.data(), text.size(), 0) == std::ssize(text);
  require(written, "{}: could not be written: {}", (folder_ / lock_name).string(),
          std::strerror(errno));
}

void FolderLock::share() {
  take_lock(file_.number(), LOCK_SH, folder_);
  kind_ = Kind::beside;
}

}  // namespace gabion
