// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>

#include "common/base/error.hpp"
#include "common/checkpoint/checkpoint_folder.hpp"
#include "common/checkpoint/checkpoints.hpp"
#include "common/checkpoint/state_file.hpp"
#include "common/settings/scene.hpp"

namespace gabion {
namespace {

namespace fs = std::filesystem;

class CheckpointFolder : public testing::Test {
 protected:
  void SetUp() override { fs::create_directories(results_); }
  void TearDown() override { fs::remove_all(results_); }

  static Checkpoint made(std::int64_t step) {
    State soil;
    soil.facts = {{"name", "soil"}};
    soil.reals["x"] = {static_cast<double>(step), -0.0, 1.0 / 3, HUGE_VAL};
    soil.reals["empty"] = {};
    soil.integers["cell"] = {-1, std::int64_t{1} << 60};
    return {{step, 0.1 * static_cast<double>(step)}, {{"soil", soil}, {"run", {}}}};
  }

  std::string results_ =
      (fs::temp_directory_path() / ("gabion_checkpoint_" + std::to_string(getpid()))).string();
  fs::path all_ = fs::path(results_) / "checkpoints";
};

TEST_F(CheckpointFolder, ReadsBackEveryBit) {
  write_checkpoint(results_, "coupler", made(7));
  const Checkpoint found = read_checkpoint(find_checkpoint(results_), "coupler");
  EXPECT_EQ(found.point.step, 7);
  EXPECT_EQ(found.point.time, 0.1 * 7);
  const Checkpoint written = made(7);
  const State &saved = written.state_of("soil"), &back = found.state_of("soil");
  EXPECT_EQ(back.facts, saved.facts);
  EXPECT_EQ(back.reals, saved.reals);
  EXPECT_TRUE(std::signbit(back.reals.at("x")[1]));
  EXPECT_EQ(back.integers, saved.integers);
  EXPECT_THROW(found.state_of("structure"), ConfigError);
}

TEST_F(CheckpointFolder, TheLastWholeOneCounts) {
  EXPECT_THROW(find_checkpoint(results_), ConfigError);
  write_checkpoint(results_, "coupler", made(9));
  write_checkpoint(results_, "coupler", made(10));
  EXPECT_FALSE(fs::exists(all_ / "step_000009"));
  fs::create_directories(all_ / "step_000011");  // a run was killed while it wrote this one
  write_state((all_ / "step_000011" / "soil.h5").string(), made(11).states.at("soil"));
  fs::create_directories(all_ / "step_other");
  EXPECT_EQ(find_checkpoint(results_), (all_ / "step_000010").string());
  write_checkpoint(results_, "coupler", made(11));
  EXPECT_EQ(read_checkpoint(find_checkpoint(results_), "coupler").point.step, 11);
  EXPECT_FALSE(fs::exists(all_ / "step_000010"));
}

TEST_F(CheckpointFolder, DamageAndOtherRunsAreRefused) {
  write_checkpoint(results_, "coupler", made(3));
  const std::string path = find_checkpoint(results_);
  EXPECT_THROW(read_checkpoint(path, "mpm_solver"), ConfigError);
  fs::resize_file(fs::path(path) / "soil.h5", fs::file_size(fs::path(path) / "soil.h5") / 2);
  EXPECT_THROW(read_checkpoint(path, "coupler"), Error);
  std::ofstream(fs::path(path) / "manifest.json") << "{\"format\": ";
  EXPECT_THROW(read_checkpoint(path, "coupler"), Error);
}

TEST_F(CheckpointFolder, AFailedWriteLeavesTheLastOne) {
  write_checkpoint(results_, "coupler", made(3));
  Checkpoint bad = made(4);
  bad.states["no/folder"] = {};
  EXPECT_THROW(write_checkpoint(results_, "coupler", bad), Error);
  EXPECT_EQ(read_checkpoint(find_checkpoint(results_), "coupler").point.step, 3);
}

TEST_F(CheckpointFolder, ResultsThatTheNewRunWouldReplaceAreRefused) {
  const auto write = [&](const std::string& name, const std::string& text) {
    fs::create_directories((fs::path(results_) / name).parent_path());
    std::ofstream(fs::path(results_) / name) << text;
  };
  write("scene/coupler.json", "{}");
  const Scene scene(results_ + "/scene", {});
  const auto refusal = [&](const std::string& restart) {
    try {
      Checkpoints::load(results_ + restart, results_ + "/out", "coupler", scene);
    } catch (const Error& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  const std::string words = "would be replaced by the new results";
  for (const std::string name : {"out", "out.previous", "out.failed"}) {
    write(name + "/summary.json", R"({"completed": true})");
  }
  EXPECT_NE(refusal("/out.previous").find(words), std::string::npos);
  EXPECT_NE(refusal("/out.failed").find("found no checkpoint"), std::string::npos);
  write("out/summary.json", R"({"completed": false})");  // goes to out.failed
  EXPECT_NE(refusal("/out").find(words), std::string::npos);
  EXPECT_NE(refusal("/out.failed").find(words), std::string::npos);
  EXPECT_NE(refusal("/out.previous").find("found no checkpoint"), std::string::npos);
}

}  // namespace
}  // namespace gabion
