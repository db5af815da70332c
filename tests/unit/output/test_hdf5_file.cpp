// SPDX-License-Identifier: BSD-3-Clause
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <fstream>
#include <random>

#include "common/hdf5/hdf5_file.hpp"
#include "tests/unit/output/output_folder.hpp"
#include "tests/unit/output/small_disk.hpp"

namespace gabion::test_hdf5_file {
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

/// Bytes that the file takes for a dataset.
hsize_t stored_bytes(const std::string& file, const std::string& dataset) {
  const hid_t file_id = H5Fopen(file.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
  const hid_t data = H5Dopen2(file_id, dataset.c_str(), H5P_DEFAULT);
  const hsize_t bytes = H5Dget_storage_size(data);
  H5Dclose(data);
  H5Fclose(file_id);
  return bytes;
}

/// Noise, equal values, noise in the low bytes only, and values with all bits set, over the ends of
/// chunks and of the size from which on numbers are compressed.
TEST_F(Hdf5FileTest, compressed_values_are_the_same_to_the_bit) {
  std::mt19937_64 random(1);
  for (const std::size_t rows : {1, 511, 512, 4095, 4096, 4097, 8192, 20001}) {
    SCOPED_TRACE(rows);
    std::vector<double> reals(3 * rows);
    std::vector<float> small(rows);
    std::vector<std::int64_t> large(rows);
    std::vector<std::int32_t> equal(rows, -1);
    for (std::size_t i = 0; i < reals.size(); ++i) {
      reals[i] = i % 3 == 0 ? 0.0 : 1 + 1e-6 * std::generate_canonical<double, 53>(random);
    }
    for (std::size_t i = 0; i < rows; ++i) {
      small[i] = i < rows / 2 ? 0.0f : std::generate_canonical<float, 24>(random);
      large[i] = static_cast<std::int64_t>(random() >> 12);  // a double holds it
    }
    Hdf5File file(path("a.h5"));
    file.write("reals", 3, reals);
    file.write("small", 1, small);
    file.write("large", 1, large);
    file.write("equal", 1, equal);
    file.finish();
    EXPECT_EQ(read_dataset(path("a.h5"), "reals"), reals);
    EXPECT_EQ(read_dataset(path("a.h5"), "small"), std::vector<double>(small.begin(), small.end()));
    EXPECT_EQ(read_dataset(path("a.h5"), "large"), std::vector<double>(large.begin(), large.end()));
    EXPECT_EQ(read_dataset(path("a.h5"), "equal"), std::vector<double>(rows, -1.0));
  }
}

TEST_F(Hdf5FileTest, what_repeats_is_stored_in_fewer_bytes_and_noise_in_hardly_more) {
  constexpr std::size_t n = 40960;
  std::vector<std::int32_t> grid(n);  // bytes that spread, in a short pattern
  for (std::size_t i = 0; i < n; ++i) grid[i] = static_cast<std::int32_t>(i / 8 + i % 8);
  Hdf5File file(path("a.h5"));
  file.write("noise", 1, noise(n));
  file.write("zeros", 1, std::vector<double>(n, 0.0));
  file.write("grid", 1, grid);
  file.write("few", 1, std::vector<double>(100, 0.0));
  file.finish();
  const hsize_t bytes = n * sizeof(double);
  EXPECT_LT(stored_bytes(path("a.h5"), "noise"), bytes + bytes / 100);
  EXPECT_LT(stored_bytes(path("a.h5"), "zeros"), bytes / 100);
  EXPECT_LT(stored_bytes(path("a.h5"), "grid"), n * sizeof(std::int32_t) / 3);
  EXPECT_EQ(stored_bytes(path("a.h5"), "few"), 100 * sizeof(double));
}

/// Chunks are taken over only where bytes and columns are those of the file before.
TEST_F(Hdf5FileTest, kept_chunks_are_those_of_equal_values) {
  const std::vector<double> first = noise(12000);
  std::vector<double> other = first;
  other.back() += 1;
  KeptChunks kept({"mesh"});
  const auto expect_kept = [&](const std::vector<double>& values, int columns) {
    Hdf5File file(path("a.h5"), &kept);
    file.write("mesh", columns, values);
    file.write("field", columns, values);
    file.finish();
    std::vector<hsize_t> sizes;
    EXPECT_EQ(read_dataset(path("a.h5"), "mesh", &sizes), values);
    EXPECT_EQ(sizes[0], values.size() / columns);
    EXPECT_EQ(read_dataset(path("a.h5"), "field"), values);
  };
  for (int file = 0; file < 2; ++file) expect_kept(first, 1);
  expect_kept(first, 3);
  kept = KeptChunks({"mesh"});
  for (const bool same : {true, true, false, true}) expect_kept(same ? first : other, 1);

  KeptChunks mesh({"mesh"});
  const ArrayBytes bytes{.bytes = {reinterpret_cast<const unsigned char*>(first.data()),
                                   first.size() * sizeof(double)},
                         .row_size = sizeof(double),
                         .value_size = sizeof(double),
                         .real = true};
  const auto once = mesh.press("mesh", bytes, 4096);
  EXPECT_EQ(mesh.press("mesh", bytes, 4096), once);  // not compressed again
  EXPECT_NE(mesh.press("field", bytes, 4096), mesh.press("field", bytes, 4096));
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
}  // namespace gabion::test_hdf5_file
