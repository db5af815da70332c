// SPDX-License-Identifier: BSD-3-Clause
#include "common/hdf5/array_file.hpp"

#include <hdf5.h>

namespace gabion {

void ArrayFile::write(const std::string& dataset, int columns, std::span<const float> values) {
  write_numbers(dataset, columns, {H5T_NATIVE_FLOAT, sizeof(float), values.size(), values.data()});
}

void ArrayFile::write(const std::string& dataset, int columns, std::span<const double> values) {
  write_numbers(dataset, columns,
                {H5T_NATIVE_DOUBLE, sizeof(double), values.size(), values.data()});
}

void ArrayFile::write(const std::string& dataset, int columns,
                      std::span<const std::int32_t> values) {
  write_numbers(dataset, columns,
                {H5T_NATIVE_INT32, sizeof(std::int32_t), values.size(), values.data()});
}

void ArrayFile::write(const std::string& dataset, int columns,
                      std::span<const std::int64_t> values) {
  write_numbers(dataset, columns,
                {H5T_NATIVE_INT64, sizeof(std::int64_t), values.size(), values.data()});
}

}  // namespace gabion
