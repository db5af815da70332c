// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>

#include "common/checkpoint/checkpoint_folder.hpp"
#include "common/checkpoint/checkpoints.hpp"
#include "common/checkpoint/file_crc32.hpp"
#include "common/checkpoint/state_file.hpp"
#include "common/settings/scene.hpp"
#include "tests/support/expect_error.hpp"

namespace gabion::test_checkpoint_folder {
namespace {

namespace fs = std::filesystem;
using test::expect_error;

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

TEST_F(CheckpointFolder, reads_back_every_bit) {
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
  expect_error<ConfigError>([&] { found.state_of("structure"); },
                            {"step 7: found no state of \"structure\", but of run, soil"});
}

/// A solver has written the file of its part; it is read by the solver too.
TEST_F(CheckpointFolder, files_of_solvers_are_left_to_them) {
  Checkpoint own = made(8);
  begin_checkpoint(results_, own.point);
  const fs::path file = all_ / "step_000008" / "soil.h5";
  std::ofstream(file) << "of its own";
  own.states["soil"] = {};
  own.states["soil"].file = file.string();
  write_checkpoint(results_, "coupler", own);
  const std::string path = find_checkpoint(results_);
  const Checkpoint found = read_checkpoint(path, "coupler");
  EXPECT_EQ(found.state_of("soil").file, file.string());
  EXPECT_TRUE(found.state_of("run").file.empty());
  std::ofstream(file, std::ios::app) << " and more";
  expect_error<Error>([&] { read_checkpoint(path, "coupler"); },
                      {"soil.h5: found 19 bytes, the manifest says 10: damaged"});
}

TEST_F(CheckpointFolder, the_last_whole_one_counts) {
  expect_error<ConfigError>([&] { find_checkpoint(results_); },
                            {results_, "found no checkpoint there"});
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

TEST_F(CheckpointFolder, damage_and_other_runs_are_refused) {
  write_checkpoint(results_, "coupler", made(3));
  const std::string path = find_checkpoint(results_);
  expect_error<ConfigError>([&] { read_checkpoint(path, "mpm_solver"); },
                            {path, "/program: found \"coupler\"", "allowed: \"mpm_solver\""});
  fs::resize_file(fs::path(path) / "soil.h5", fs::file_size(fs::path(path) / "soil.h5") / 2);
  expect_error<Error>([&] { read_checkpoint(path, "coupler"); },
                      {"soil.h5: found ", "the manifest says", "damaged"});
  std::ofstream(fs::path(path) / "manifest.json") << "{\"format\": ";
  expect_error<ConfigError>([&] { read_checkpoint(path, "coupler"); },
                            {"manifest.json: not valid JSON"});
}

/// Change one bit of a file in place.
void flip(const fs::path& file, std::uintmax_t place) {
  std::fstream bytes(file, std::ios::in | std::ios::out | std::ios::binary);
  bytes.seekg(static_cast<std::streamoff>(place));
  const char changed = static_cast<char>(bytes.get() ^ 0x10);
  bytes.seekp(static_cast<std::streamoff>(place));
  bytes.put(changed);
}

/// Every changed bit is found, in files that a solver wrote too; nothing else is wrong with them.
TEST_F(CheckpointFolder, changed_bytes_of_equal_size_are_refused) {
  Checkpoint all = made(3);
  begin_checkpoint(results_, all.point);
  const fs::path own = all_ / "step_000003" / "own.h5";
  std::ofstream(own) << "of its own";
  all.states["own"].file = own.string();
  write_checkpoint(results_, "coupler", all);
  const std::string path = find_checkpoint(results_);
  for (const std::string name : {"soil.h5", "run.h5", "own.h5"}) {
    const fs::path file = fs::path(path) / name;
    const auto size = fs::file_size(file);
    for (const auto place : {std::uintmax_t{0}, size / 2, size - 1}) {
      flip(file, place);
      expect_error<Error>([&] { read_checkpoint(path, "coupler"); },
                          {name + ": found bytes of CRC-32 \"", "the manifest says \"",
                           "damaged; restart from", "without --restart"});
      flip(file, place);
    }
  }
  EXPECT_EQ(read_checkpoint(path, "coupler").state_of("own").file, own.string());
}

TEST_F(CheckpointFolder, checksums_are_those_of_gzip) {
  const fs::path file = fs::path(results_) / "check";
  std::ofstream(file) << "123456789";
  EXPECT_EQ(file_crc32(file.string()), "cbf43926");  // the check value of ISO 3309
  std::ofstream(file) << std::string(3 << 20, '\0');
  EXPECT_EQ(file_crc32(file.string()), "79724fc6");  // several chunks; python3: zlib.crc32
  std::ofstream{file};
  EXPECT_EQ(file_crc32(file.string()), "00000000");
  expect_error<Error>([&] { file_crc32(results_); }, {results_, "cannot read this file"});
}

/// Checkpoints of earlier versions go on; what is not checked is said.
TEST_F(CheckpointFolder, a_manifest_of_format_1_has_no_checksums) {
  write_checkpoint(results_, "coupler", made(3));
  const std::string path = find_checkpoint(results_);
  const fs::path file = fs::path(path) / "manifest.json";
  Json manifest = Json::parse(std::ifstream(file));
  manifest.erase("crc32");
  std::ofstream(file) << manifest;
  expect_error<ConfigError>([&] { read_checkpoint(path, "coupler"); },
                            {"at /crc32: found null", "allowed: an object with a text for"});
  manifest["format"] = 1;
  std::ofstream(file) << manifest;
  testing::internal::CaptureStderr();
  EXPECT_EQ(read_checkpoint(path, "coupler").point.step, 3);
  EXPECT_NE(testing::internal::GetCapturedStderr().find("of format 1, without checksums"),
            std::string::npos);
}

/// A manifest has values of every type where another one is expected.
TEST_F(CheckpointFolder, manifests_are_checked_key_by_key) {
  write_checkpoint(results_, "coupler", made(3));
  const std::string path = find_checkpoint(results_);
  const fs::path file = fs::path(path) / "manifest.json";
  const Json good = Json::parse(std::ifstream(file));
  for (const auto& item : good.items()) {
    for (const Json& wrong : {Json(), Json(-1), Json(0.5), Json("x"), Json({{"../x", 1}}),
                              Json::array({1}), Json(1e300), Json(true)}) {
      const std::string key = item.key();
      if (key == "version" || key == "own_files" || (key == "time" && wrong.is_number_float())) {
        continue;  // another version is only warned of, and no file of its own is told
      }
      Json manifest = good;
      manifest[key] = wrong;
      std::ofstream(file) << manifest;
      const auto refused = [&] {
        try {
          read_checkpoint(path, "coupler");
        } catch (const Error& problem) {
          EXPECT_NE(std::string(problem.what()).find("manifest.json"), std::string::npos)
              << problem.what();
          return true;
        }
        return false;
      };
      EXPECT_TRUE(refused()) << manifest;
    }
  }
  std::ofstream(file) << std::string(100000, '[');
  expect_error<ConfigError>([&] { read_checkpoint(path, "coupler"); }, {"nested deeper"});
  fs::create_directories(all_ / "step_99999999999999999999");
  std::ofstream(all_ / "step_99999999999999999999" / "manifest.json") << "{}";
  EXPECT_EQ(find_checkpoint(results_), path);
}

TEST_F(CheckpointFolder, a_failed_write_leaves_the_last_one) {
  write_checkpoint(results_, "coupler", made(3));
  Checkpoint bad = made(4);
  bad.states["no/folder"] = {};
  expect_error<Error>([&] { write_checkpoint(results_, "coupler", bad); },
                      {"no/folder.h5", "cannot create this file"});
  EXPECT_EQ(read_checkpoint(find_checkpoint(results_), "coupler").point.step, 3);
}

TEST_F(CheckpointFolder, results_that_the_new_run_would_replace_are_refused) {
  const auto write = [&](const std::string& name, const std::string& text) {
    fs::create_directories((fs::path(results_) / name).parent_path());
    std::ofstream(fs::path(results_) / name) << text;
  };
  write("scene/coupler.json", "{}");
  const Scene scene(results_ + "/scene", {});
  const auto refuses = [&](const std::string& restart, const std::string& text) {
    expect_error<ConfigError>(
        [&] { Checkpoints::load(results_ + restart, results_ + "/out", "coupler", scene); },
        {text});
  };
  const std::string words = "would be replaced by the new results";
  for (const std::string name : {"out", "out.previous", "out.failed"}) {
    write(name + "/summary.json", R"({"completed": true})");
  }
  refuses("/out.previous", words);
  refuses("/out.failed", "found no checkpoint");
  write("out/summary.json", R"({"completed": false})");  // goes to out.failed
  refuses("/out", words);
  refuses("/out.failed", words);
  refuses("/out.previous", "found no checkpoint");
}

}  // namespace
}  // namespace gabion::test_checkpoint_folder
