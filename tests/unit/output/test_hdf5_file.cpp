// SPDX-License-Identifier: BSD-3-Clause
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <fstream>
#include <random>

#include "common/hdf5/hdf5_file.hpp"
#include "tests/unit/output/output_folder.hpp"
#include "tests/unit/output/small_disk.hpp"

namespace gabion {
namespace {

using test::expect_error;
using test::read_dataset;

class Hdf5FileTest : public test::OutputFolder {};

std::vector<double> noise(std::size_t n) {
  std::mt19937_64 random(1);
  std::vector<double> values(n);
  for (auto& value : values) value = std::generate_canonical<double, 53>(random);
  return values;
}

TEST_F(Hdf5FileTest, reads_back_what_was_written) {
  const auto values = noise(30000);
  const std::vector<std::int32_t> numbers = {7, -8, 9};
  const std::vector<float> small = {0.5f, 0.25f};
  Hdf5File file(path("a.h5"));
  file.write("deep/down/values", 3, values);
  file.write("numbers", 1, numbers);
  file.write("small", 2, small);
  file.write("nothing", 3, std::span<const double>());
  EXPECT_EQ(files(), std::vector<std::string>{"a.h5.part"});
  file.finish();
  EXPECT_EQ(files(), std::vector<std::string>{"a.h5"});

  std::vector<hsize_t> sizes;
  EXPECT_EQ(read_dataset(path("a.h5"), "deep/down/values", &sizes), values);
  EXPECT_EQ(sizes, (std::vector<hsize_t>{10000, 3}));
  EXPECT_EQ(read_dataset(path("a.h5"), "numbers", &sizes), (std::vector<double>{7, -8, 9}));
  EXPECT_EQ(sizes, std::vector<hsize_t>{3});
  EXPECT_EQ(read_dataset(path("a.h5"), "small", &sizes), (std::vector<double>{0.5, 0.25}));
  EXPECT_TRUE(read_dataset(path("a.h5"), "nothing", &sizes).empty());
}

TEST_F(Hdf5FileTest, equal_data_give_equal_files) {
  const auto values = noise(500);
  std::string bytes[2];
  for (int i = 0; i < 2; ++i) {
    Hdf5File file(path("same.h5"));
    file.write("point/values", 1, values);
    file.write_text("facts", "{}");
    file.finish();
    std::ifstream in(path("same.h5"), std::ios::binary);
    bytes[i].assign(std::istreambuf_iterator<char>(in), {});
    if (i == 0) usleep(1100000);  // a time stamp would differ
  }
  EXPECT_FALSE(bytes[0].empty());
  EXPECT_TRUE(bytes[0] == bytes[1]);
}

TEST_F(Hdf5FileTest, an_unfinished_file_leaves_nothing) {
  {
    Hdf5File file(path("a.h5"));
    file.write("values", 1, noise(100));
  }
  EXPECT_TRUE(files().empty());
}

TEST_F(Hdf5FileTest, a_killed_writer_leaves_the_old_frame_whole) {
  const auto before = noise(100);
  Hdf5File first(path("a.h5"));
  first.write("values", 1, before);
  first.finish();
  const pid_t child = fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    Hdf5File file(path("a.h5"));
    file.write("values", 1, noise(200000));
    raise(SIGKILL);
  }
  int status = 0;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  EXPECT_TRUE(WIFSIGNALED(status));
  EXPECT_EQ(files(), (std::vector<std::string>{"a.h5", "a.h5.part"}));
  EXPECT_EQ(read_dataset(path("a.h5"), "values"), before);
  Hdf5File again(path("a.h5"));  // the left-over is no obstacle
  again.write("values", 1, before);
  again.finish();
  EXPECT_EQ(files(), std::vector<std::string>{"a.h5"});
}

TEST_F(Hdf5FileTest, errors_name_the_file_and_the_cause) {
  const std::string lost = path("no/such/folder.h5");
  expect_error<Error>([&] { Hdf5File{lost}; },
                      {lost + ": cannot create this file: ", "No such file or directory"});
  expect_error<Error>(
      [&] {
        Hdf5File file(path("a.h5"));
        file.write("values", 1, noise(3));
        file.write("values", 1, noise(3));
      },
      {path("a.h5") + ": cannot write dataset values: "});
  EXPECT_TRUE(files().empty());
}

TEST_F(Hdf5FileTest, a_full_disk_is_an_error_and_leaves_nothing) {
  for (const rlim_t size : {100, 3000, 200000}) {
    SCOPED_TRACE(size);
    {
      const test::SmallDisk disk(size);
      expect_error<Error>(
          [&] {
            Hdf5File file(path("a.h5"));
            file.write("values", 1, noise(100000));
            file.finish();
          },
          {path("a.h5") + ": cannot ", "File too large"});
    }
    EXPECT_TRUE(files().empty());
  }
  Hdf5File file(path("a.h5"));  // and the library works on
  file.write("values", 1, noise(10));
  file.finish();
  EXPECT_EQ(read_dataset(path("a.h5"), "values"), noise(10));
}

}  // namespace
}  // namespace gabion
