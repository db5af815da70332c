// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "common/run/folder_lock.hpp"
#include "common/run/result_files.hpp"
#include "common/run/results_folder.hpp"
#include "common/run/run_record.hpp"
#include "tests/support/expect_error.hpp"
#include "tests/support/temp_folder.hpp"

namespace gabion::test_results_folder {
namespace {

namespace fs = std::filesystem;
using test::TempFolder;

void write(const fs::path& file, const std::string& text = "mine") {
  fs::create_directories(file.parent_path());
  std::ofstream(file) << text;
}

std::string text_of(const fs::path& file) {
  std::ifstream in(file);
  return {std::istreambuf_iterator<char>(in), {}};
}

/// All below a folder that is no folder, by relative name, in order.
std::vector<std::string> files_in(const fs::path& folder) {
  std::vector<std::string> files;
  if (!fs::exists(folder)) return files;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    const bool is_folder = fs::is_directory(entry.symlink_status());
    if (!is_folder) files.push_back(entry.path().lexically_relative(folder).generic_string());
  }
  std::ranges::sort(files);
  return files;
}

void expect_refused(const std::string& folder, const std::vector<std::string_view>& parts) {
  test::expect_error<ConfigError>([&] { RunRecord record(folder, "coupler"); }, parts);
}

std::string signature(const ProcessIdentity& process) {
  return Json({{"program", "mpm_solver"},
               {"host", process.host},
               {"pid", process.pid},
               {"start_time", process.start_time},
               {"since", "2026-01-02 03:04:05 UTC"}})
      .dump();
}

/// A process with a record in this folder, until it is killed.
class OtherRun {
 public:
  explicit OtherRun(const std::string& folder) {
    std::array<int, 2> begun{};
    EXPECT_EQ(pipe(begun.data()), 0);
    pid_ = fork();
    if (pid_ == 0) {
      try {
        const RunRecord record(folder, "coupler");
        EXPECT_EQ(::write(begun[1], "x", 1), 1);
        for (;;) pause();
      } catch (const std::exception&) {
        _exit(1);
      }
    }
    close(begun[1]);
    char sign = ' ';
    EXPECT_EQ(read(begun[0], &sign, 1), 1) << "the other run did not begin";
    close(begun[0]);
  }
  ~OtherRun() { kill_it(); }
  OtherRun(const OtherRun&) = delete;
  OtherRun& operator=(const OtherRun&) = delete;
  OtherRun(OtherRun&&) = delete;
  OtherRun& operator=(OtherRun&&) = delete;

  std::string pid() const { return std::to_string(pid_); }
  void kill_it() {
    if (pid_ <= 0) return;
    kill(pid_, SIGKILL);
    waitpid(pid_, nullptr, 0);
    pid_ = 0;
  }

 private:
  pid_t pid_ = 0;
};

TEST(FolderLock, second_run_is_refused_and_named) {
  const TempFolder temp;
  {
    const RunRecord first(temp / "out", "coupler");
    write(temp / "out/steps.csv", "rows of the first");
    const std::string pid = "(pid " + std::to_string(getpid()) + " on ";
    expect_refused(temp / "out", {"in use by coupler", pid, ", since 2", "out/.gabion_lock"});
    expect_refused(temp / "out/", {"in use by coupler"});
    EXPECT_EQ(text_of(temp / "out/steps.csv"), "rows of the first");
    EXPECT_FALSE(fs::exists(temp / "out.previous"));
  }
  EXPECT_EQ(text_of(temp / "out/.gabion_lock"), "");  // cleared at the end
  const RunRecord second(temp / "out", "coupler");
  EXPECT_EQ(text_of(temp / "out.previous/steps.csv"), "rows of the first");
}

TEST(FolderLock, lock_of_a_killed_run_is_stale) {
  const TempFolder temp;
  OtherRun other(temp / "out");
  expect_refused(temp / "out", {"in use by coupler", "pid " + other.pid()});
  test::expect_error<ConfigError>([&] { check_results_folder(temp / "out", "coupler"); },
                                  {"in use by coupler"});
  other.kill_it();
  EXPECT_NE(text_of(temp / "out/.gabion_lock"), "");
  check_results_folder(temp / "out", "coupler");
  const RunRecord next(temp / "out", "coupler");
  EXPECT_TRUE(fs::exists(temp / "out.previous/.gabion_results"));
}

TEST(FolderLock, place_of_the_earlier_results_may_be_in_use_too) {
  const TempFolder temp;
  for (int run = 0; run < 2; ++run) RunRecord(temp / "out", "coupler");
  const OtherRun other(temp / "out.previous");
  expect_refused(temp / "out", {"out.previous: in use by coupler", "pid " + other.pid()});
  EXPECT_TRUE(fs::exists(temp / "out/.gabion_results"));
}

TEST(FolderLock, who_writes_below_a_folder_keeps_it_in_place) {
  const TempFolder temp;
  { const RunRecord run(temp / "out", "coupler"); }
  fs::create_directories(temp / "out/mpm");
  const FolderLock results(temp / "out", FolderLock::Kind::beside);
  FolderLock own(temp / "out/mpm", FolderLock::Kind::alone);
  own.sign("mpm_solver");
  expect_refused(temp / "out", {"in use by mpm_solver", "out/mpm/.gabion_lock"});
  test::expect_error<ConfigError>([&] { FolderLock(temp / "out/mpm", FolderLock::Kind::alone); },
                                  {"in use by mpm_solver"});
  const FolderLock others(temp / "out", FolderLock::Kind::beside);
}

/// Signatures decide where a file system has no locks that all machines know.
TEST(FolderLock, signatures_of_processes_that_may_live) {
  const TempFolder temp;
  const ProcessIdentity self = this_process();
  const auto count_with = [&](const std::string& text, const std::string& file) {
    write(temp / file, text);
    const auto owners = owners_that_may_live(temp / "out");
    fs::remove(temp / file);
    return owners.size();
  };
  for (const std::string file :
       {"out/.gabion_lock", "out/.gabion_lock_plot", "out/mpm/.gabion_lock"}) {
    EXPECT_EQ(count_with(signature(self), file), 1u);
    EXPECT_EQ(count_with(signature({"other/machine", self.pid, self.start_time}), file), 1u);
    EXPECT_EQ(count_with(signature({"", self.pid, self.start_time}), file), 1u);
    // The number was given to another process.
    EXPECT_EQ(count_with(signature({self.host, self.pid, self.start_time - 1}), file), 0u);
    EXPECT_EQ(count_with(signature({self.host, 1 << 30, self.start_time}), file), 0u);
    EXPECT_EQ(count_with("", file), 0u);
    EXPECT_EQ(count_with("{\"program\": \"mpm_so", file), 0u);
    EXPECT_EQ(count_with("{\"program\": 1}", file), 0u);
  }
}

/// Results as the programs and scripts write them.
void write_results(const fs::path& folder) {
  for (const std::string name : {"steps.csv",
                                 "iterations.csv",
                                 "probes.csv",
                                 "coupler.log",
                                 "scene.xdmf",
                                 "report.html",
                                 "mpm/resolved_config.json",
                                 "mpm/soil.xdmf",
                                 "mpm/soil_000000.h5",
                                 "mpm/soil_1234567.h5",
                                 "mpm/contact_wall.xdmf",
                                 "mpm/contact_wall_000001.h5",
                                 "fem/structure_000000.h5",
                                 "plate/frame_000001.frd",
                                 "plate/frames.csv",
                                 "plate/structure_p0_000000.vtu",
                                 "plate/structure000000.pvtu",
                                 "plate/structure.pvd",
                                 "plate/frame_0001.vtu",
                                 "checkpoints/step_000010/run.h5",
                                 "checkpoints/step_000010/manifest.json",
                                 "plots/probes.png",
                                 "plots/contact_wall.png",
                                 "plots/scene.gif",
                                 "deposit/depth.asc",
                                 "deposit/deposit.png",
                                 "map/max_depth.asc",
                                 "map/max_depth.prj",
                                 "map/arrival.tif",
                                 "map/section_dam.csv"}) {
    write(folder / name, "ours");
  }
  write(folder / "resolved_config.json", R"({"coupler.json": {"participants": {"plate": {}}}})");
}

TEST(ResultsFolder, nothing_is_kept_of_what_the_programs_wrote) {
  const TempFolder temp;
  for (int run = 0; run < 4; ++run) {
    const RunRecord record(temp / "out", "coupler");
    write_results(temp / "out");
  }
  EXPECT_TRUE(fs::exists(temp / "out.previous/plots/probes.png"));
  EXPECT_FALSE(fs::exists(temp / "out.kept"));
}

TEST(ResultsFolder, files_of_others_are_never_removed) {
  const TempFolder temp;
  const std::vector<std::string> theirs = {"best/soil.xdmf",
                                           "checkpoints/copy_of_step_000010/run.h5",
                                           "checkpoints/step_000010/notes.txt",
                                           "deposit/depth.tif",
                                           "map/hazard.gpkg",
                                           "mpm/soil_1_best.h5",
                                           "notes.txt",
                                           "plate/mesh.inp",
                                           "plots/figure_1.png",
                                           "steps.ods"};
  {
    const RunRecord record(temp / "out", "coupler");
    write_results(temp / "out");
    for (const std::string& name : theirs) write(fs::path(temp / "out") / name);
    write(temp / "data/big.h5");
    fs::create_symlink(temp / "data/big.h5", temp / "out/mpm/soil_000009.h5");
    fs::create_directory_symlink(temp / "data", temp / "out/deposit/data");
  }
  for (int run = 0; run < 4; ++run) {
    const RunRecord record(temp / "out", "coupler");
    write_results(temp / "out");
    if (run == 1) write(temp / "out/notes.txt", "others");
  }
  std::vector<std::string> kept = theirs;
  kept.insert(kept.end(), {"deposit/data", "mpm/soil_000009.h5"});
  std::ranges::sort(kept);
  EXPECT_EQ(files_in(temp / "out.kept"), kept);
  EXPECT_EQ(text_of(temp / "out.kept/notes.txt"), "mine");
  EXPECT_EQ(text_of(temp / "data/big.h5"), "mine");
  EXPECT_EQ(text_of(temp / "out.kept_2/notes.txt"), "others");
}

TEST(ResultsFolder, links_are_followed) {
  const TempFolder temp;
  fs::create_directories(temp / "disk");
  fs::create_directory_symlink("disk/results", temp / "out");  // leads nowhere yet
  fs::create_directory_symlink("out", temp / "link");
  for (const std::string text : {"first", "second", "third"}) {
    const RunRecord record(temp / "link/", "coupler");
    record.write_json("summary.json", {{"run", text}});
  }
  EXPECT_TRUE(fs::is_symlink(temp / "out"));
  EXPECT_TRUE(fs::is_symlink(temp / "link"));
  EXPECT_NE(text_of(temp / "out/summary.json").find("third"), std::string::npos);
  EXPECT_NE(text_of(temp / "disk/results.previous/summary.json").find("second"), std::string::npos);
  EXPECT_EQ(place_of_earlier_results(temp / "link"), temp / "disk/results.previous");
  EXPECT_FALSE(fs::exists(temp / "out.previous"));
  EXPECT_FALSE(fs::exists(temp / "link.previous"));

  fs::create_symlink("ring", temp / "ring");
  expect_refused(temp / "ring", {"output folder", "ring"});
}

TEST(ResultsFolder, two_names_of_one_folder) {
  const TempFolder temp;
  fs::create_directory_symlink("out", temp / "link");
  const RunRecord first(temp / "out", "coupler");
  expect_refused(temp / "link", {"in use by coupler"});
}

TEST(ResultsFolder, files_of_others_in_a_checkpoint) {
  const TempFolder temp;
  write(temp / "step_000001/run.h5");
  write(temp / "step_000001/manifest.json");
  write(temp / "step_000001/notes.txt");
  EXPECT_FALSE(remove_checkpoint_files(temp / "step_000001"));
  EXPECT_EQ(files_in(temp / "step_000001"), std::vector<std::string>{"notes.txt"});
  fs::remove(temp / "step_000001/notes.txt");
  write(temp / "step_000001/run.h5");
  EXPECT_TRUE(remove_checkpoint_files(temp / "step_000001"));
}

}  // namespace
}  // namespace gabion::test_results_folder
