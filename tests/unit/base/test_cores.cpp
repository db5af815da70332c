// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>
#include <sched.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "common/base/cores.hpp"
#include "tests/support/temp_folder.hpp"

namespace gabion::test_cores {
namespace {

namespace fs = std::filesystem;
using test::TempFolder;

void write(const fs::path& file, const std::string& text) {
  fs::create_directories(file.parent_path());
  std::ofstream(file) << text << '\n';
}

TEST(Cores, threads_of_one_core_count_once) {
  const TempFolder temp;
  const fs::path folder = temp / "cpu";
  for (const int cpu : {0, 1, 2, 3}) {
    write(folder / ("cpu" + std::to_string(cpu)) / "topology/thread_siblings_list",
          cpu % 2 == 0 ? "0,2" : "1,3");
  }
  using Cores = std::vector<std::vector<int>>;
  EXPECT_EQ(cores_of({0, 1, 2, 3}, folder), (Cores{{0, 2}, {1, 3}}));
  EXPECT_EQ(cores_of({0, 2}, folder), (Cores{{0, 2}}));
  EXPECT_EQ(cores_of({1, 2}, folder).size(), 2);
  EXPECT_EQ(cores_of({4, 5}, folder).size(), 2);  // the system says nothing of these
}

TEST(Cores, quota_is_the_least_of_a_group_and_those_above) {
  const TempFolder temp;
  const fs::path root = temp / "cgroup";
  write(root / "a/cpu.max", "350000 100000");
  write(root / "a/b/cpu.max", "max 100000");
  write(root / "a/c/cpu.max", "50000 100000");
  EXPECT_EQ(quota_of_group(root, "/a/b"), 3);
  EXPECT_EQ(quota_of_group(root, "/a/c"), 1);  // half a processor
  EXPECT_EQ(quota_of_group(root, "/other"), 0);
  EXPECT_EQ(quota_of_group(root, "/"), 0);
  EXPECT_EQ(quota_of_group(root, ""), 0);
  write(root / "cpu.max", "200000 100000");  // as inside a container
  EXPECT_EQ(quota_of_group(root, "/"), 2);
  EXPECT_EQ(quota_of_group(root, ""), 2);
  EXPECT_EQ(quota_of_group(root, "/a/b"), 2);
}

TEST(Cores, a_core_is_as_idle_as_its_busiest_thread) {
  const std::string before =
      "cpu  1 1 1 1 1 1 1 1 0 0\ncpu0 100 0 50 1000 10 0 0 0 0 0\n"
      "cpu1 100 0 50 1000 10 0 0 0 0 0\ncpu10 0 0 0 0 0 0 0 0 0 0\nintr 5\n";
  const std::string after =
      "cpu  1 1 1 1 1 1 1 1 0 0\ncpu0 110 5 55 1070 20 0 0 0 0 0\n"
      "cpu1 150 0 50 1000 10 0 0 50 0 0\ncpu10 10 0 0 0 0 0 0 0 0 0\nintr 9\n";
  EXPECT_DOUBLE_EQ(idle_between(before, after, {{0}}).value(), 0.8);  // that waits for the disk too
  EXPECT_DOUBLE_EQ(idle_between(before, after, {{1}}).value(), 0);    // half of it the host's
  EXPECT_DOUBLE_EQ(idle_between(before, after, {{0}, {1}, {10}}).value(), 0.8);
  EXPECT_DOUBLE_EQ(idle_between(before, after, {{0, 1}}).value(), 0);
  EXPECT_FALSE(idle_between(before, after, {{2}}));  // is not there
  EXPECT_FALSE(idle_between(before, before, {{0}}));
  EXPECT_FALSE(idle_between(before, after, {}));
  EXPECT_FALSE(idle_between("", "", {{0}}));
  EXPECT_FALSE(idle_between("cpu0 1 2\n", "cpu0 2 3\n", {{0}}));
}

TEST(Cores, mask_of_this_process_counts) {
  cpu_set_t before;
  ASSERT_EQ(sched_getaffinity(0, sizeof before, &before), 0);
  EXPECT_GE(usable_cores(), 1);
  EXPECT_LE(usable_cores(), CPU_COUNT(&before));
  cpu_set_t one;
  CPU_ZERO(&one);
  for (int cpu = 0; CPU_COUNT(&one) == 0; ++cpu) {
    if (CPU_ISSET(cpu, &before)) CPU_SET(cpu, &one);
  }
  ASSERT_EQ(sched_setaffinity(0, sizeof one, &one), 0);
  EXPECT_EQ(usable_cores(), 1);
  ASSERT_EQ(sched_setaffinity(0, sizeof before, &before), 0);
}

}  // namespace
}  // namespace gabion::test_cores
