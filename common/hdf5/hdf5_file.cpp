// SPDX-License-Identifier: BSD-3-Clause
#include "common/hdf5/hdf5_file.hpp"

#include <fmt/format.h>

#include <cassert>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <system_error>
#include <utility>

#include "common/base/error.hpp"
#include "common/hdf5/hdf5_dataset.hpp"

namespace gabion {

namespace {

/// Memory grows by this much [bytes].
constexpr std::size_t memory_increment = 1 << 20;

}  // namespace

void Hdf5File::fail(const std::string& what, const std::string& cause) const {
  throw Error(fmt::format("{}: cannot {}: {}", path_, what, cause));
}

Hdf5File::Hdf5File(std::string path, KeptChunks* kept)
    : path_(std::move(path)), part_path_(path_ + ".part"), kept_(kept) {
  errno = 0;
  out_.open(part_path_, std::ios::binary | std::ios::trunc);
  if (!out_.is_open()) fail("create this file", std::strerror(errno));
  const QuietErrors quiet;
  Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
  if (access.id() >= 0 && H5Pset_fapl_core(access.id(), memory_increment, false) >= 0) {
    file_ = H5Fcreate(path_.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, access.id());
  }
  if (file_ < 0) {
    const std::string cause = hdf5_cause();
    abandon();
    fail("create this file", cause);
  }
}

Hdf5File::~Hdf5File() {
  if (out_.is_open()) abandon();
}

void Hdf5File::abandon() {
  const QuietErrors quiet;
  if (file_ >= 0) H5Fclose(std::exchange(file_, -1));
  out_.close();
  std::error_code ignored;
  std::filesystem::remove(part_path_, ignored);
}

void Hdf5File::write_text(const std::string& dataset, const std::string& text) {
  assert(file_ >= 0);
  const QuietErrors quiet;
  Handle data(new_text(file_, dataset, text.size()), H5Dclose);
  Handle type(data.id() < 0 ? -1 : H5Dget_type(data.id()), H5Tclose);
  const bool good =
      type.id() >= 0 &&
      H5Dwrite(data.id(), type.id(), H5S_ALL, H5S_ALL, H5P_DEFAULT, text.c_str()) >= 0 &&
      data.close();
  if (!good) fail(fmt::format("write dataset {}", dataset), hdf5_cause());
}

bool Hdf5File::write_chunks(const std::string& dataset, std::int64_t data, const ArrayBytes& array,
                            std::size_t rows_a_chunk) {
  const auto chunks =
      kept_ ? kept_->press(dataset, array, rows_a_chunk)
            : std::make_shared<const PressedChunks>(press_chunks(array, rows_a_chunk));
  constexpr std::uint32_t all_filters = 0;
  hsize_t place[2] = {0, 0};
  for (const auto& chunk : *chunks) {
    if (H5Dwrite_chunk(data, H5P_DEFAULT, all_filters, place, chunk.size(), chunk.data()) < 0) {
      return false;
    }
    place[0] += rows_a_chunk;
  }
  return true;
}

void Hdf5File::write_numbers(const std::string& dataset, int columns, const Numbers& numbers) {
  assert(file_ >= 0 && columns > 0 && numbers.count % columns == 0);
  const QuietErrors quiet;
  const DatasetSize size{.rows = numbers.count / columns, .columns = static_cast<hsize_t>(columns)};
  Handle data(new_dataset(file_, dataset, numbers.type, size), H5Dclose);
  const auto rows_a_chunk = static_cast<std::size_t>(chunk_rows_of(size, numbers.size));
  bool good = data.id() >= 0;
  if (good && rows_a_chunk > 0) {
    const ArrayBytes array{
        .bytes = {static_cast<const unsigned char*>(numbers.data), numbers.count * numbers.size},
        .row_size = numbers.size * static_cast<std::size_t>(columns),
        .value_size = numbers.size,
        .real = H5Tget_class(numbers.type) == H5T_FLOAT};
    good = write_chunks(dataset, data.id(), array, rows_a_chunk);
  } else if (good && numbers.count > 0) {
    good = H5Dwrite(data.id(), numbers.type, H5S_ALL, H5S_ALL, H5P_DEFAULT, numbers.data) >= 0;
  }
  good = good && data.close();
  if (!good) fail(fmt::format("write dataset {}", dataset), hdf5_cause());
}

void Hdf5File::finish() {
  assert(file_ >= 0);
  const QuietErrors quiet;
  const bool flushed = H5Fflush(file_, H5F_SCOPE_LOCAL) >= 0;
  const ssize_t size = flushed ? H5Fget_file_image(file_, nullptr, 0) : -1;
  if (size <= 0) fail("write this file", hdf5_cause());
  // The core driver's handle is the place of its pointer to the file in memory.
  void* handle = nullptr;
  if (H5Fget_vfd_handle(file_, H5P_DEFAULT, &handle) < 0) fail("write this file", hdf5_cause());
  const char* const image = *static_cast<const char* const*>(handle);

  errno = 0;
  out_.write(image, size);
  out_.flush();
  if (!out_.good()) {
    const std::string cause = std::strerror(errno);
    abandon();
    fail("write this file", cause);
  }
  out_.close();
  if (H5Fclose(std::exchange(file_, -1)) < 0) fail("write this file", hdf5_cause());
  std::error_code error;
  std::filesystem::rename(part_path_, path_, error);
  if (error) fail("give the written file its name", error.message());
}

}  // namespace gabion
