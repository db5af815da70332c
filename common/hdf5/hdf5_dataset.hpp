// SPDX-License-Identifier: BSD-3-Clause
// This header is for the files that call HDF5 themselves.
#pragma once

#include <string>

#include "common/hdf5/hdf5_handle.hpp"

namespace gabion {

struct DatasetSize {
  hsize_t rows = 0;
  hsize_t columns = 1;  ///< 1: the dataset has one extent
  int rank() const { return columns == 1 ? 1 : 2; }
};

/// Rows of a chunk of a dataset; 0: it has no chunks and is not compressed.
/// @param value_size  [bytes] of one number
hsize_t chunk_rows_of(const DatasetSize& size, std::size_t value_size);

/// A new dataset for numbers, compressed by byte shuffle and deflate level 1 where it has chunks.
/// Groups of its name are made when missing.
/// @returns  identifier, to be closed; negative: hdf5_cause() says why
hid_t new_dataset(hid_t file, const std::string& name, hid_t type, const DatasetSize& size);

/// Like new_dataset(), for one text of `length` bytes.
hid_t new_text(hid_t file, const std::string& name, std::size_t length);

}  // namespace gabion
