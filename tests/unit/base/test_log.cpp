// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <regex>
#include <string>
#include <vector>

#include "common/base/log.hpp"
#include "common/base/printable.hpp"

namespace gabion::test_log {
namespace {

namespace fs = std::filesystem;

std::vector<std::string> lines_of(const fs::path& path) {
  std::ifstream in(path);
  std::vector<std::string> lines;
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  fs::remove(path);  // the name; the sink lives as long as the process
  return lines;
}

TEST(Log, lines_of_the_file_carry_time_prefix_and_level_once) {
  const fs::path path =
      fs::temp_directory_path() / ("gabion_log_" + std::to_string(getpid()) + ".log");
  log::start("cpl", log::Level::info, true);
  log::also_to_file(path.string());
  log::info("step {}", 1);
  log::debug("not shown");
  log::warn("dt cut");
  log::last_error("lost");
  log::last_error("lost");
  const auto lines = lines_of(path);
  ASSERT_EQ(lines.size(), 3u);
  const std::string time = R"(\d{4}-\d\d-\d\d \d\d:\d\d:\d\d\.\d{3} )";
  EXPECT_TRUE(std::regex_match(lines[0], std::regex(time + R"(\[cpl\] step 1)"))) << lines[0];
  EXPECT_TRUE(std::regex_match(lines[1], std::regex(time + R"(\[cpl\] warning: dt cut)")))
      << lines[1];
  EXPECT_TRUE(std::regex_match(lines[2], std::regex(time + R"(\[cpl\] error: lost)"))) << lines[2];
}

TEST(Log, texts_of_others_cannot_rule_a_terminal_or_forge_a_line) {
  EXPECT_EQ(printable("plain, \t and höher: Δt ≤ 1"), "plain, \t and höher: Δt ≤ 1");
  EXPECT_EQ(printable("\x1b[2Jred\x1b[31m\a\r"), "\\x1b[2Jred\\x1b[31m\\x07\\x0d");
  EXPECT_EQ(printable("a\n[cpl] done"), "a\n    [cpl] done");
  EXPECT_EQ(printable("\xc2\x9b"
                      "2J\x7f"),
            "\\xc2\\x9b"
            "2J\\x7f");
  EXPECT_EQ(printable("\xe2\x80\xae"
                      "txt"),
            "\\xe2\\x80\\xae"
            "txt");
  EXPECT_EQ(printable("\xff\xc0\xaf\xed\xa0\x80\xe2\x82"),
            "\\xff\\xc0\\xaf\\xed\\xa0\\x80\\xe2\\x82");
  EXPECT_EQ(printable(std::string_view("\0", 1)), "\\x00");
  EXPECT_EQ(printable("\xf0\x9f\x8f\x94"), "\xf0\x9f\x8f\x94");
}

}  // namespace
}  // namespace gabion::test_log
