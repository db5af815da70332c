// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace gabion {

/// The bytes of an array, row-major.
struct ArrayBytes {
  std::span<const unsigned char> bytes;
  std::size_t row_size = 0;    ///< [bytes], > 0
  std::size_t value_size = 0;  ///< [bytes], of one number
  bool real = false;           ///< a floating-point number, whose low bytes are often noise
};

/// Chunks of a dataset as HDF5's filters shuffle and deflate (RFC 1950) store them.
using PressedChunks = std::vector<std::vector<unsigned char>>;

/// Compress an array in chunks of `chunk_rows` rows; the last chunk is filled up with zeros.
///
/// Shuffling puts the first bytes of all values together, then the second ones, and so on. Low
/// bytes of real numbers that spread like noise are stored as they are: to deflate them takes most
/// of the time and saves next to nothing. Everything else is deflated at level 1.
/// @param array  of values of 4 or 8 bytes
/// @throws Error  no memory
PressedChunks press_chunks(const ArrayBytes& array, std::size_t chunk_rows);

/// Remembers the chunks of some datasets from one file of a series to the next, so that what does
/// not change, such as a mesh, is compressed once. A dataset that has changed is not tried again.
class KeptChunks {
 public:
  /// @param datasets  the names of those that are remembered
  explicit KeptChunks(const std::vector<std::string>& datasets);

  /// The chunks of press_chunks(array, chunk_rows), kept ones where the array has the same bytes.
  std::shared_ptr<const PressedChunks> press(const std::string& dataset, const ArrayBytes& array,
                                             std::size_t chunk_rows);

 private:
  struct Kept {
    std::vector<unsigned char> bytes;
    std::size_t row_size = 0;
    std::shared_ptr<const PressedChunks> chunks;  // null: nothing was written so far
  };
  std::map<std::string, Kept> kept_;
};

}  // namespace gabion
