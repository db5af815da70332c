// SPDX-License-Identifier: BSD-3-Clause
#include "common/hdf5/hdf5_reader.hpp"

#include <fmt/format.h>

#include <utility>

#include "common/base/require.hpp"
#include "common/hdf5/hdf5_handle.hpp"

namespace gabion {

void Hdf5Reader::fail(const std::string& what) const {
  throw Error(fmt::format("{}: cannot read {}: {}", path_, what, hdf5_cause()));
}

Hdf5Reader::Hdf5Reader(std::string path) : path_(std::move(path)) {
  const QuietErrors quiet;
  file_ = H5Fopen(path_.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
  if (file_ < 0) fail("this file");
}

Hdf5Reader::~Hdf5Reader() {
  H5Fclose(file_);
}

std::vector<std::string> Hdf5Reader::names(const std::string& group) const {
  const QuietErrors quiet;
  if (H5Lexists(file_, group.c_str(), H5P_DEFAULT) <= 0) return {};
  Handle handle(H5Gopen2(file_, group.c_str(), H5P_DEFAULT), H5Gclose);
  if (handle.id() < 0) fail(group);
  std::vector<std::string> names;
  const auto add = [](hid_t, const char* name, const H5L_info_t*, void* list) -> herr_t {
    static_cast<std::vector<std::string>*>(list)->emplace_back(name);
    return 0;
  };
  if (H5Literate(handle.id(), H5_INDEX_NAME, H5_ITER_INC, nullptr, add, &names) < 0) fail(group);
  return names;
}

namespace {

hid_t type_of(const double*) {
  return H5T_NATIVE_DOUBLE;
}
hid_t type_of(const std::int64_t*) {
  return H5T_NATIVE_INT64;
}

}  // namespace

/// @param range  null: all values
template <class Value>
std::vector<Value> Hdf5Reader::read(const std::string& dataset, int type_class,
                                    const ValueRange* range) const {
  const QuietErrors quiet;
  Handle data(H5Dopen2(file_, dataset.c_str(), H5P_DEFAULT), H5Dclose);
  if (data.id() < 0) fail(dataset);
  Handle space(H5Dget_space(data.id()), H5Sclose);
  Handle stored(H5Dget_type(data.id()), H5Tclose);
  if (space.id() < 0 || stored.id() < 0) fail(dataset);
  require(static_cast<int>(H5Tget_class(stored.id())) == type_class,
          "{}: dataset {} has another type of value than expected", path_, dataset);
  const hssize_t size = H5Sget_simple_extent_npoints(space.id());
  if (size < 0) fail(dataset);
  const auto count = static_cast<hsize_t>(range ? range->count : size);
  if (range) {
    require(range->first >= 0 && range->count >= 0 && range->first + range->count <= size &&
                H5Sget_simple_extent_ndims(space.id()) == 1,
            "{}: dataset {}: found {} values, expected {} behind {} of one extent", path_, dataset,
            size, range->count, range->first);
    const auto first = static_cast<hsize_t>(range->first);
    if (count > 0 &&
        H5Sselect_hyperslab(space.id(), H5S_SELECT_SET, &first, nullptr, &count, nullptr) < 0) {
      fail(dataset);
    }
  }
  std::vector<Value> values(count);
  const Handle own(H5Screate_simple(1, &count, nullptr), H5Sclose);
  if (count > 0 && H5Dread(data.id(), type_of(values.data()), own.id(), space.id(), H5P_DEFAULT,
                           values.data()) < 0) {
    fail(dataset);
  }
  return values;
}

std::vector<double> Hdf5Reader::reals(const std::string& dataset) const {
  return read<double>(dataset, H5T_FLOAT, nullptr);
}

std::vector<std::int64_t> Hdf5Reader::integers(const std::string& dataset) const {
  return read<std::int64_t>(dataset, H5T_INTEGER, nullptr);
}

std::vector<double> Hdf5Reader::reals(const std::string& dataset, const ValueRange& range) const {
  return read<double>(dataset, H5T_FLOAT, &range);
}

std::vector<std::int64_t> Hdf5Reader::integers(const std::string& dataset,
                                               const ValueRange& range) const {
  return read<std::int64_t>(dataset, H5T_INTEGER, &range);
}

std::int64_t Hdf5Reader::size(const std::string& dataset) const {
  const QuietErrors quiet;
  Handle data(H5Dopen2(file_, dataset.c_str(), H5P_DEFAULT), H5Dclose);
  if (data.id() < 0) fail(dataset);
  Handle space(H5Dget_space(data.id()), H5Sclose);
  const hssize_t size = space.id() < 0 ? -1 : H5Sget_simple_extent_npoints(space.id());
  if (size < 0) fail(dataset);
  return size;
}

std::string Hdf5Reader::text(const std::string& dataset) const {
  const QuietErrors quiet;
  Handle data(H5Dopen2(file_, dataset.c_str(), H5P_DEFAULT), H5Dclose);
  if (data.id() < 0) fail(dataset);
  Handle type(H5Dget_type(data.id()), H5Tclose);
  if (type.id() < 0 || H5Tget_class(type.id()) != H5T_STRING) fail(dataset);
  std::string text(H5Tget_size(type.id()), '\0');
  if (H5Dread(data.id(), type.id(), H5S_ALL, H5S_ALL, H5P_DEFAULT, text.data()) < 0) fail(dataset);
  text.resize(text.find('\0'));
  return text;
}

}  // namespace gabion
