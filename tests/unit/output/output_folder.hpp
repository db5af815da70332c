// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <gtest/gtest.h>
#include <hdf5.h>

#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

#include "tests/support/expect_error.hpp"

namespace gabion::test {

/// A fresh folder for each test.
class OutputFolder : public testing::Test {
 protected:
  void SetUp() override {
    const auto* info = testing::UnitTest::GetInstance()->current_test_info();
    folder_ = std::filesystem::temp_directory_path() /
              (std::string("gabion_") + info->test_suite_name() + "_" + info->name());
    std::filesystem::remove_all(folder_);
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  std::string path(const std::string& file) const { return (folder_ / file).string(); }
  std::vector<std::string> files() const {
    std::vector<std::string> names;
    for (const auto& entry : std::filesystem::directory_iterator(folder_)) {
      names.push_back(entry.path().filename().string());
    }
    std::sort(names.begin(), names.end());
    return names;
  }

  std::filesystem::path folder_;
};

/// All values of a dataset as double, and its sizes.
inline std::vector<double> read_dataset(const std::string& file, const std::string& dataset,
                                        std::vector<hsize_t>* sizes = nullptr) {
  const hid_t file_id = H5Fopen(file.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
  const hid_t data = H5Dopen2(file_id, dataset.c_str(), H5P_DEFAULT);
  const hid_t space = H5Dget_space(data);
  std::vector<double> values(std::max<hssize_t>(0, H5Sget_simple_extent_npoints(space)));
  if (sizes != nullptr) {
    sizes->resize(H5Sget_simple_extent_ndims(space));
    H5Sget_simple_extent_dims(space, sizes->data(), nullptr);
  }
  const herr_t status =
      H5Dread(data, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data());
  EXPECT_GE(status, 0) << file << ":/" << dataset;
  H5Sclose(space);
  H5Dclose(data);
  H5Fclose(file_id);
  return values;
}

}  // namespace gabion::test
