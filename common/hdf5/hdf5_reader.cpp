// SPDX-License-Identifier: BSD-3-Clause
#include "common/hdf5/hdf5_reader.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <utility>

#include "common/base/read_file.hpp"
#include "common/base/require.hpp"
#include "common/hdf5/hdf5_handle.hpp"

namespace gabion {

void Hdf5Reader::fail(const std::string& what) const {
  throw Error(fmt::format("{}: cannot read {}: {}", path_, what, hdf5_cause()));
}

Hdf5Reader::Hdf5Reader(std::string path) : path_(std::move(path)) {
  require_file(path_, "HDF5 file");
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

/// Bytes of values that one byte of a file can hold, after Deutsch (1996), RFC 1951: at most 1032.
constexpr hsize_t largest_compression = 1032;

struct Room {
  hid_t memory_type;
  std::size_t bytes;    // size of a value
  const char* allowed;  // types that fit
};
Room room_of(const double*) {
  return {H5T_NATIVE_DOUBLE, sizeof(double), "floating-point numbers of at most 8 bytes"};
}
Room room_of(const std::int64_t*) {
  return {H5T_NATIVE_INT64, sizeof(std::int64_t),
          "integers of at most 8 bytes, without a sign of at most 4"};
}

bool is_unsigned(hid_t type) {
  return H5Tget_class(type) == H5T_INTEGER && H5Tget_sign(type) == H5T_SGN_NONE;
}

/// Whether each value of a stored type has one of the type in memory.
bool fits(hid_t stored, const Room& room) {
  const std::size_t size = H5Tget_size(stored);
  if (H5Tget_class(stored) != H5Tget_class(room.memory_type) || size == 0) return false;
  return is_unsigned(stored) ? size < room.bytes : size <= room.bytes;
}

/// Words for a stored type, for messages.
std::string type_text(hid_t stored) {
  switch (H5Tget_class(stored)) {
    case H5T_FLOAT:
      return fmt::format("floating-point numbers of {} bytes", H5Tget_size(stored));
    case H5T_INTEGER:
      return fmt::format("integers{} of {} bytes", is_unsigned(stored) ? " without a sign" : "",
                         H5Tget_size(stored));
    case H5T_STRING:
      return "texts";
    case H5T_ENUM:
      return "an enumeration, such as booleans";
    case H5T_COMPOUND:
      return "records of several values, such as complex numbers";
    default:
      return "values of another kind";
  }
}

/// Whether the values of a dataset are in this file: a name inside a file must not lead to another
/// one.
bool holds_own_values(hid_t dataset) {
  const Handle creation(H5Dget_create_plist(dataset), H5Pclose);
  if (creation.id() < 0) return false;
  const H5D_layout_t layout = H5Pget_layout(creation.id());
  return (layout == H5D_COMPACT || layout == H5D_CONTIGUOUS || layout == H5D_CHUNKED) &&
         H5Pget_external_count(creation.id()) == 0;
}

}  // namespace

/// Nothing is allocated for what the file cannot hold.
void Hdf5Reader::require_stored(const std::string& dataset, std::int64_t id,
                                std::uint64_t bytes) const {
  hsize_t file_bytes = 0;
  if (H5Fget_filesize(file_, &file_bytes) < 0) fail(dataset);
  const hsize_t stored = std::min(H5Dget_storage_size(id), file_bytes);
  require(bytes / largest_compression <= stored && (bytes == 0 || stored > 0),
          "{}: dataset {}: found {} bytes for values of {}: the file is damaged", path_, dataset,
          stored, bytes);
}

/// @param range  null: all values
template <class Value>
std::vector<Value> Hdf5Reader::read(const std::string& dataset, const ValueRange* range) const {
  const QuietErrors quiet;
  const Room room = room_of(static_cast<const Value*>(nullptr));
  Handle data(H5Dopen2(file_, dataset.c_str(), H5P_DEFAULT), H5Dclose);
  if (data.id() < 0) fail(dataset);
  Handle space(H5Dget_space(data.id()), H5Sclose);
  Handle stored(H5Dget_type(data.id()), H5Tclose);
  if (space.id() < 0 || stored.id() < 0) fail(dataset);
  require(fits(stored.id(), room), "{}: dataset {}: found {}, allowed: {}", path_, dataset,
          type_text(stored.id()), room.allowed);
  require(holds_own_values(data.id()),
          "{}: dataset {}: found values that another file holds, allowed: in this one", path_,
          dataset);
  const hssize_t size = H5Sget_simple_extent_npoints(space.id());
  if (size < 0) fail(dataset);
  const auto count = static_cast<hsize_t>(range ? range->count : size);
  if (range) {
    require(range->first >= 0 && range->count >= 0 && range->first <= size - range->count &&
                H5Sget_simple_extent_ndims(space.id()) == 1,
            "{}: dataset {}: found {} values, expected {} behind {} of one extent", path_, dataset,
            size, range->count, range->first);
    const auto first = static_cast<hsize_t>(range->first);
    if (count > 0 &&
        H5Sselect_hyperslab(space.id(), H5S_SELECT_SET, &first, nullptr, &count, nullptr) < 0) {
      fail(dataset);
    }
  }
  require(size <= std::numeric_limits<hssize_t>::max() / static_cast<hssize_t>(room.bytes),
          "{}: dataset {}: found {} values, allowed: what a file can hold", path_, dataset, size);
  require_stored(dataset, data.id(), static_cast<hsize_t>(size) * H5Tget_size(stored.id()));
  std::vector<Value> values(count);
  const Handle own(H5Screate_simple(1, &count, nullptr), H5Sclose);
  if (count > 0 &&
      H5Dread(data.id(), room.memory_type, own.id(), space.id(), H5P_DEFAULT, values.data()) < 0) {
    fail(dataset);
  }
  return values;
}

std::vector<double> Hdf5Reader::reals(const std::string& dataset) const {
  return read<double>(dataset, nullptr);
}

std::vector<std::int64_t> Hdf5Reader::integers(const std::string& dataset) const {
  return read<std::int64_t>(dataset, nullptr);
}

std::vector<double> Hdf5Reader::numbers(const std::string& dataset) const {
  const QuietErrors quiet;
  const Handle data(H5Dopen2(file_, dataset.c_str(), H5P_DEFAULT), H5Dclose);
  if (data.id() < 0) fail(dataset);
  const Handle stored(H5Dget_type(data.id()), H5Tclose);
  if (stored.id() < 0) fail(dataset);
  if (H5Tget_class(stored.id()) != H5T_INTEGER) return reals(dataset);
  const std::vector<std::int64_t> whole = integers(dataset);
  return {whole.begin(), whole.end()};
}

std::vector<double> Hdf5Reader::reals(const std::string& dataset, const ValueRange& range) const {
  return read<double>(dataset, &range);
}

std::vector<std::int64_t> Hdf5Reader::integers(const std::string& dataset,
                                               const ValueRange& range) const {
  return read<std::int64_t>(dataset, &range);
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

std::vector<std::int64_t> Hdf5Reader::shape(const std::string& dataset) const {
  const QuietErrors quiet;
  Handle data(H5Dopen2(file_, dataset.c_str(), H5P_DEFAULT), H5Dclose);
  if (data.id() < 0) fail(dataset);
  Handle space(H5Dget_space(data.id()), H5Sclose);
  const int count = space.id() < 0 ? -1 : H5Sget_simple_extent_ndims(space.id());
  if (count < 0) fail(dataset);
  std::vector<hsize_t> sizes(static_cast<std::size_t>(count));
  if (count > 0 && H5Sget_simple_extent_dims(space.id(), sizes.data(), nullptr) != count) {
    fail(dataset);
  }
  return {sizes.begin(), sizes.end()};
}

std::string Hdf5Reader::text(const std::string& dataset) const {
  const QuietErrors quiet;
  Handle data(H5Dopen2(file_, dataset.c_str(), H5P_DEFAULT), H5Dclose);
  if (data.id() < 0) fail(dataset);
  Handle type(H5Dget_type(data.id()), H5Tclose);
  Handle space(H5Dget_space(data.id()), H5Sclose);
  if (type.id() < 0 || space.id() < 0) fail(dataset);
  require(H5Tget_class(type.id()) == H5T_STRING && H5Tis_variable_str(type.id()) == 0 &&
              H5Sget_simple_extent_npoints(space.id()) == 1 && holds_own_values(data.id()),
          "{}: dataset {} is not one text of fixed length", path_, dataset);
  const std::size_t size = H5Tget_size(type.id());
  require_stored(dataset, data.id(), size);
  std::string text(size, '\0');
  if (H5Dread(data.id(), type.id(), H5S_ALL, H5S_ALL, H5P_DEFAULT, text.data()) < 0) fail(dataset);
  const std::size_t end = text.find('\0');
  require(end != std::string::npos, "{}: dataset {} is a text without an end", path_, dataset);
  text.resize(end);
  return text;
}

}  // namespace gabion
