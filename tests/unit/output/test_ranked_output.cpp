// SPDX-License-Identifier: BSD-3-Clause
// Files that several ranks write together.
#include <limits>
#include <numeric>
#include <random>

#include "common/mechanics/output/ranked_hdf5_file.hpp"
#include "common/mechanics/output/xdmf_series.hpp"
#include "common/mechanics/ranks/share.hpp"
#include "tests/support/mpi_main.hpp"
#include "tests/unit/output/output_folder.hpp"
#include "tests/unit/output/small_disk.hpp"

namespace gabion::test::test_ranked_output {
namespace {

/// One folder for all ranks.
class RankedOutput : public OutputFolder {
 protected:
  void SetUp() override {
    if (rank() == 0) OutputFolder::SetUp();
    MPI_Barrier(comm());
    folder_ = testing::TempDir() + "gabion_";
    const auto* info = testing::UnitTest::GetInstance()->current_test_info();
    folder_ += std::string(info->test_suite_name()) + "_" + info->name();
  }
  void TearDown() override {
    MPI_Barrier(comm());
    if (rank() == 0) OutputFolder::TearDown();
    MPI_Barrier(comm());
  }
};

std::vector<double> counted(std::int64_t first, std::int64_t count) {
  std::vector<double> values(static_cast<std::size_t>(count));
  std::iota(values.begin(), values.end(), 0.1 + static_cast<double>(first));
  return values;
}

/// The ranks have unequal parts, the first one none, and chunks lie across their borders.
TEST_F(RankedOutput, datasets_are_those_of_one_rank) {
  const RowShare share = share_of_rows(comm(), size() == 1 ? 7000 : 7000 * rank());
  const std::vector<double> values = counted(3 * share.first, 3 * share.count);
  const std::vector<std::int64_t> number = {1000 + rank()};
  const std::vector<float> small(values.begin(), values.end());
  const std::vector<std::int32_t> none;
  const auto file = new_array_file(path("a.h5"), comm());
  file->write("deep/down/values", 3, values);
  file->write("deep/number", 1, number);
  file->write("small", 1, small);
  file->write("none", 2, none);
  file->write_text("facts", "{\"a\": 1}");
  file->finish();
  EXPECT_EQ(files(), std::vector<std::string>{"a.h5"});

  std::vector<hsize_t> sizes;
  EXPECT_EQ(read_dataset(path("a.h5"), "deep/down/values", &sizes), counted(0, 3 * share.total));
  EXPECT_EQ(sizes, (std::vector<hsize_t>{static_cast<hsize_t>(share.total), 3}));
  const auto numbers = read_dataset(path("a.h5"), "deep/number");
  ASSERT_EQ(numbers.size(), static_cast<std::size_t>(size()));
  EXPECT_EQ(numbers.back(), 999 + size());
  EXPECT_EQ(read_dataset(path("a.h5"), "small", &sizes).back(),
            static_cast<float>(3 * share.total - 0.9));
  EXPECT_TRUE(read_dataset(path("a.h5"), "none", &sizes).empty());
}

TEST_F(RankedOutput, an_unfinished_file_leaves_nothing) {
  {
    const auto file = new_array_file(path("a.h5"), comm());
    file->write("values", 1, counted(0, 100));
  }
  MPI_Barrier(comm());
  EXPECT_TRUE(files().empty());
}

TEST_F(RankedOutput, errors_are_those_of_all_ranks) {
  const std::string lost = path("no/such/folder.h5");
  expect_error<Error>([&] { new_array_file(lost, comm()); },
                      {lost + ": cannot create this file: ", "No such file or directory"});
  expect_error<Error>(
      [&] {
        const auto file = new_array_file(path("a.h5"), comm());
        file->write("values", 1, counted(0, 3));
        file->write("values", 1, counted(0, 3));
      },
      {path("a.h5") + ": cannot write dataset values: "});
  MPI_Barrier(comm());
  EXPECT_TRUE(files().empty());
}

TEST_F(RankedOutput, a_full_disk_is_an_error_on_all_ranks_and_leaves_nothing) {
  std::mt19937_64 random(1);  // next to nothing to compress
  std::vector<double> noise(100000);
  for (double& value : noise) value = std::generate_canonical<double, 53>(random);
  for (const rlim_t bytes : {100, 100000, 600000}) {
    SCOPED_TRACE(bytes);
    {
      const SmallDisk disk(bytes);
      expect_error<Error>(
          [&] {
            const auto file = new_array_file(path("a.h5"), comm());
            file->write("first", 1, counted(0, 100));
            file->write("values", 1, noise);
            file->finish();
          },
          {path("a.h5") + ": cannot ", "File too large"});
    }
    MPI_Barrier(comm());
    EXPECT_TRUE(files().empty());
    MPI_Barrier(comm());
  }
  const auto file = new_array_file(path("a.h5"), comm());  // and the library works on
  file->write("values", 1, counted(10 * rank(), 10));
  file->finish();
  EXPECT_EQ(read_dataset(path("a.h5"), "values"), counted(0, 10 * size()));
}

TEST_F(RankedOutput, a_series_has_the_points_of_all_ranks) {
  XdmfSeries series(folder_.string(), "soil", comm());
  const std::vector<double> x(2 * (3 + rank()), rank()), p(3 + rank(), 10.0 * rank());
  series.write({.time = 0.5, .coordinates = x, .fields = {{"a", 1, p}, {.name = "b", .make = [&] {
                                                                          return p;
                                                                        }}}});
  const auto total = static_cast<std::size_t>(3 * size() + size() * (size() - 1) / 2);
  const auto cells = read_dataset(path("soil_000000.h5"), "connectivity");
  ASSERT_EQ(cells.size(), total);
  EXPECT_EQ(cells.back(), static_cast<double>(total - 1));
  EXPECT_EQ(read_dataset(path("soil_000000.h5"), "coordinates").size(), 3 * total);
  const auto b = read_dataset(path("soil_000000.h5"), "point/b");
  EXPECT_EQ(read_dataset(path("soil_000000.h5"), "point/a"), b);
  EXPECT_EQ(b.back(), 10.0 * (size() - 1));
  EXPECT_EQ(files(), (std::vector<std::string>{"soil.xdmf", "soil_000000.h5"}));
}

TEST_F(RankedOutput, a_value_of_one_rank_that_does_not_fit_is_an_error_on_all) {
  XdmfSeries series(folder_.string(), "soil", comm());
  const std::vector<double> x = {0, 0};
  const std::vector<double> large = {rank() == size() - 1 ? 1e300 : 0};
  expect_error<Error>(
      [&] {
        series.write({.coordinates = x, .fields = {{"a", 1, large}}});
      },
      {"output field a: found 1e+300"});
  const std::vector<double> few(rank() == size() - 1 ? 2 : 1, 0.0);
  expect_error<Error>(
      [&] {
        series.write({.coordinates = x, .fields = {{"a", 1, few}}});
      },
      {"output field a: found 2 values, expected 1 x 1"});
  MPI_Barrier(comm());
  EXPECT_TRUE(files().empty());
}

}  // namespace
}  // namespace gabion::test::test_ranked_output
