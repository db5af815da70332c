// SPDX-License-Identifier: BSD-3-Clause
#include "common/mechanics/output/ranked_hdf5_file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cassert>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <system_error>
#include <utility>

#include "common/base/error.hpp"
#include "common/hdf5/hdf5_dataset.hpp"
#include "common/hdf5/hdf5_file.hpp"
#include "common/mechanics/ranks/share.hpp"
#include "common/mechanics/ranks/text.hpp"

namespace gabion {

namespace {

/// Room for what HDF5 itself takes of a file and of each dataset [bytes]; what compression adds to
/// numbers that it cannot press is below this share of them, and so is the list of chunks.
constexpr std::int64_t own_room = 1 << 16;
constexpr std::int64_t growth = 100;

constexpr int new_file_mode = 0666;

/// Transfer properties with which ranks write together.
Handle collective_transfer() {
  const hid_t transfer = H5Pcreate(H5P_DATASET_XFER);
  if (transfer >= 0) H5Pset_dxpl_mpio(transfer, H5FD_MPIO_COLLECTIVE);
  return {transfer, H5Pclose};
}

}  // namespace

RankedHdf5File::RankedHdf5File(std::string path, MPI_Comm comm)
    : path_(std::move(path)), part_path_(path_ + ".part"), comm_(comm) {
  try {
    open();
  } catch (const Error&) {
    abandon();
    throw;
  }
}

RankedHdf5File::~RankedHdf5File() {
  if (file_ >= 0) abandon();
}

void RankedHdf5File::open() {
  const bool first = rank_of(comm_) == 0;
  if (first) {
    room_file_ = Descriptor(
        ::open(part_path_.c_str(), O_RDWR | O_CREAT | O_TRUNC | O_CLOEXEC, new_file_mode));
  }
  require_on_all(!first || room_file_.is_open(), "create this file", std::strerror(errno));
  const bool seen = access(part_path_.c_str(), W_OK) == 0;
  require_on_all(
      seen, fmt::format("write this file from rank {} of {}", rank_of(comm_), num_ranks(comm_)),
      std::strerror(errno));
  reserve(own_room);  // a file that cannot be written cannot be closed either
  const QuietErrors quiet;
  const Handle access_list(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
  if (access_list.id() >= 0 && H5Pset_fapl_mpio(access_list.id(), comm_, MPI_INFO_NULL) >= 0) {
    file_ = H5Fcreate(part_path_.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, access_list.id());
  }
  require_on_all(file_ >= 0, "create this file", hdf5_cause());
  reserve(0);  // again: it was cut to nothing
}

void RankedHdf5File::abandon() {
  const QuietErrors quiet;
  if (file_ >= 0) H5Fclose(std::exchange(file_, -1));
  if (!room_file_.is_open()) return;
  room_file_ = {};
  std::error_code ignored;
  std::filesystem::remove(part_path_, ignored);
}

/// @throws Error  on all ranks when it is not good on one
void RankedHdf5File::require_on_all(bool good, const std::string& what,
                                    const std::string& cause) const {
  const std::string problem = fmt::format("{}: cannot {}: {}", path_, what, cause);
  const std::string told = first_text(comm_, good ? "" : problem);
  if (!told.empty()) throw Error(told);
}

/// Room for so much more.
void RankedHdf5File::reserve(std::int64_t bytes) {
  room_ += bytes;
  const int problem = room_file_.is_open() ? posix_fallocate(room_file_.number(), 0, room_) : 0;
  require_on_all(problem == 0, "write this file", std::strerror(problem));
}

void RankedHdf5File::write_numbers(const std::string& dataset, int columns,
                                   const Numbers& numbers) {
  assert(file_ >= 0 && columns > 0 && numbers.count % columns == 0);
  const RowShare share = share_of_rows(comm_, static_cast<std::int64_t>(numbers.count / columns));
  const std::int64_t bytes = share.total * columns * static_cast<std::int64_t>(numbers.size);
  reserve(bytes + bytes / growth + own_room);

  const QuietErrors quiet;
  const std::string what = fmt::format("write dataset {}", dataset);
  const DatasetSize size{.rows = static_cast<hsize_t>(share.total),
                         .columns = static_cast<hsize_t>(columns)};
  Handle data(new_dataset(file_, dataset, numbers.type, size), H5Dclose);
  require_on_all(data.id() >= 0, what, hdf5_cause());
  if (share.total > 0) {
    const hsize_t start[2] = {static_cast<hsize_t>(share.first), 0};
    const hsize_t extent[2] = {static_cast<hsize_t>(share.count), size.columns};
    const Handle own(H5Screate_simple(size.rank(), extent, nullptr), H5Sclose);
    const Handle place(H5Dget_space(data.id()), H5Sclose);
    const Handle transfer = collective_transfer();
    const herr_t selected = share.count > 0 ? H5Sselect_hyperslab(place.id(), H5S_SELECT_SET, start,
                                                                  nullptr, extent, nullptr)
                                            : H5Sselect_none(place.id());
    const bool good = selected >= 0 && H5Dwrite(data.id(), numbers.type, own.id(), place.id(),
                                                transfer.id(), numbers.data) >= 0;
    require_on_all(good, what, hdf5_cause());
  }
  require_on_all(data.close(), what, hdf5_cause());
}

void RankedHdf5File::write_text(const std::string& dataset, const std::string& text) {
  assert(file_ >= 0);
  reserve(static_cast<std::int64_t>(text.size()) + own_room);
  const QuietErrors quiet;
  const std::string what = fmt::format("write dataset {}", dataset);
  Handle data(new_text(file_, dataset, text.size()), H5Dclose);
  require_on_all(data.id() >= 0, what, hdf5_cause());
  const Handle type(H5Dget_type(data.id()), H5Tclose);
  const Handle place(H5Dget_space(data.id()), H5Sclose);
  const Handle transfer = collective_transfer();
  if (rank_of(comm_) != 0) H5Sselect_none(place.id());
  const bool good =
      H5Dwrite(data.id(), type.id(), place.id(), place.id(), transfer.id(), text.c_str()) >= 0;
  require_on_all(good && data.close(), what, hdf5_cause());
}

void RankedHdf5File::finish() {
  assert(file_ >= 0);
  const QuietErrors quiet;
  const bool flushed = H5Fflush(file_, H5F_SCOPE_GLOBAL) >= 0;  // to the disk, on every rank
  require_on_all(flushed, "write this file", hdf5_cause());
  const bool closed = H5Fclose(std::exchange(file_, -1)) >= 0;
  room_file_ = {};
  require_on_all(closed, "write this file", hdf5_cause());
  std::error_code error;
  if (rank_of(comm_) == 0) std::filesystem::rename(part_path_, path_, error);
  require_on_all(!error, "give the written file its name", error.message());
}

std::unique_ptr<ArrayFile> new_array_file(const std::string& path, MPI_Comm comm,
                                          KeptChunks* kept) {
  if (num_ranks(comm) == 1) return std::make_unique<Hdf5File>(path, kept);
  return std::make_unique<RankedHdf5File>(path, comm);
}

}  // namespace gabion
