// SPDX-License-Identifier: BSD-3-Clause
// Frames hold the points in the order of their ids, whichever rank has them.
#include <gtest/gtest.h>

#include <filesystem>
#include <numeric>

#include "common/hdf5/hdf5_reader.hpp"
#include "common/mechanics/output/numbered_rows.hpp"
#include "common/mechanics/ranks/gather.hpp"
#include "common/mechanics/ranks/share.hpp"
#include "tests/unit/mpm/collapse.hpp"

namespace gabion::test::test_frames_of_ranks {
namespace {

/// Points of ten chunks of a file, scattered over the ranks; some have left.
TEST(FramesOfRanks, rows_are_ordered_by_id_and_shared_evenly) {
  constexpr std::int64_t num_ids = 10 * 4096 + 100;
  std::vector<std::int64_t> ids;
  std::vector<double> own, expected;
  for (std::int64_t id = 0; id < num_ids; ++id) {
    if (id % 7 == 3) continue;
    const auto value = static_cast<double>(id);
    expected.insert(expected.end(), {value, -value});
    if ((id * id / 13) % size() != rank()) continue;
    ids.push_back(id);
    own.insert(own.end(), {value, -value});
  }
  const NumberedRows rows(comm(), ids, num_ids);
  const std::vector<double> share = rows.gather_rows(own, 2);
  const auto mean = static_cast<double>(expected.size()) / size();
  EXPECT_LT(static_cast<double>(share.size()), 1.5 * mean);
  const std::vector<double> all = gather<double>(comm(), share);
  if (rank() == 0) {
    EXPECT_EQ(all, expected);
  }
}

/// Soil slides out of the grid.
TEST(FramesOfRanks, are_those_of_one_rank) {
  Json json = collapse_scene({.law = "neo_hookean"});
  json["grid"] = box({0, 0}, {0.8, 1.2}, {4, 6}, "quad4");
  json["outside"] = "remove";
  json.erase("probes");
  json.erase("gauges");
  const std::filesystem::path folder = testing::TempDir() + "gabion_frames_of_ranks";
  if (rank() == 0) std::filesystem::remove_all(folder);
  MPI_Barrier(comm());
  const auto shared = make_mpm(json, comm(), folder / "shared");
  run_collapse(*shared, 1, 60);
  shared->write_output(0.1);
  if (rank() != 0) return;
  const auto alone = make_mpm(json, MPI_COMM_SELF, folder / "alone");
  run_collapse(*alone, 1, 60);
  alone->write_output(0.1);

  const Hdf5Reader a(folder / "alone" / "soil_000000.h5"), b(folder / "shared" / "soil_000000.h5");
  const auto body = a.reals("point/body");
  EXPECT_LT(body.size(), 230u);  // of 240
  EXPECT_GT(body.size(), 100u);
  EXPECT_EQ(b.reals("point/body"), body);
  EXPECT_EQ(b.integers("connectivity"), a.integers("connectivity"));
  EXPECT_EQ(b.names("point"), a.names("point"));
  const std::pair<const char*, double> tolerances[] = {
      {"coordinates", 1e-8}, {"point/displacement", 1e-6}, {"point/velocity", 1e-5}};
  for (const auto& [name, tolerance] : tolerances) {
    const auto x = a.reals(name), y = b.reals(name);
    ASSERT_EQ(y.size(), x.size()) << name;
    for (std::size_t k = 0; k < x.size(); ++k) EXPECT_NEAR(y[k], x[k], tolerance) << name;
  }
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace gabion::test::test_frames_of_ranks
