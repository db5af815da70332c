// SPDX-License-Identifier: BSD-3-Clause
#include "common/hdf5/pressed_chunks.hpp"

#include <zlib.h>

#include <algorithm>
#include <array>

#include "common/base/require.hpp"

namespace gabion {

namespace {

constexpr int fast_level = 1;
constexpr int stored_level = 0;

/// Bytes that are looked at to decide about a plane.
constexpr std::size_t sample_size = 1024;
/// Collision entropy (Renyi, 1961, of order 2) above which bytes count as noise [bits]. Shannon's
/// entropy is not below it, so that a code of the single bytes saves at most an eighth.
constexpr std::uint64_t noise_bits = 7;

/// Room for the ends of blocks where the level changes [bytes].
constexpr std::size_t room_of_level = 64;

/// One zlib stream at a time, whose level may change.
class Deflater {
 public:
  Deflater() { require_good(deflateInit(&stream_, fast_level)); }
  ~Deflater() { deflateEnd(&stream_); }
  Deflater(const Deflater&) = delete;
  Deflater& operator=(const Deflater&) = delete;
  Deflater(Deflater&&) = delete;
  Deflater& operator=(Deflater&&) = delete;

  void start(std::size_t size, std::size_t num_levels) {
    require_good(deflateReset(&stream_));
    out_.resize(compressBound(size) + num_levels * room_of_level);
    stream_.next_out = out_.data();
    stream_.avail_out = static_cast<uInt>(out_.size());
  }
  void add(std::span<unsigned char> bytes, int level) {
    stream_.next_in = nullptr;
    stream_.avail_in = 0;
    require_good(deflateParams(&stream_, level, Z_DEFAULT_STRATEGY));
    stream_.next_in = bytes.data();
    stream_.avail_in = static_cast<uInt>(bytes.size());
    require_good(deflate(&stream_, Z_NO_FLUSH));
    require(stream_.avail_in == 0, "deflate took no more bytes");
  }
  std::vector<unsigned char> finish() {
    require(deflate(&stream_, Z_FINISH) == Z_STREAM_END, "deflate did not come to its end");
    return {out_.data(), stream_.next_out};
  }

 private:
  static void require_good(int code) { require(code == Z_OK, "deflate: {}", zError(code)); }

  z_stream stream_ = {};
  std::vector<unsigned char> out_;
};

bool is_noise(std::span<const unsigned char> bytes) {
  const std::size_t stride = std::max<std::size_t>(1, bytes.size() / sample_size);
  std::array<std::uint64_t, 256> counts = {};
  std::uint64_t n = 0, collisions = 0;
  for (std::size_t i = 0; i < bytes.size(); i += stride, ++n) collisions += counts[bytes[i]]++;
  return n > 1 && (collisions << (noise_bits + 1)) < n * (n - 1);
}

/// @param to  place of `size` planes of n bytes; byte k of value i comes to plane k
template <std::size_t size>
void shuffle_values(const unsigned char* from, std::size_t n, unsigned char* to) {
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t k = 0; k < size; ++k) to[k * n + i] = from[i * size + k];
  }
}

void shuffle(std::span<const unsigned char> from, std::size_t value_size,
             std::span<unsigned char> to) {
  require(value_size == 4 || value_size == 8, "found values of {} bytes, allowed: 4, 8",
          value_size);
  const std::size_t n = from.size() / value_size;
  (value_size == 4 ? shuffle_values<4> : shuffle_values<8>)(from.data(), n, to.data());
}

}  // namespace

PressedChunks press_chunks(const ArrayBytes& array, std::size_t chunk_rows) {
  const std::size_t size = array.row_size * chunk_rows;
  const std::size_t plane_size = size / array.value_size;
  std::vector<unsigned char> last, planes(size);
  Deflater deflater;
  PressedChunks chunks;
  for (std::size_t first = 0; first < array.bytes.size(); first += size) {
    std::span<const unsigned char> chunk = array.bytes.subspan(first);
    if (chunk.size() < size) {
      last.assign(chunk.begin(), chunk.end());
      last.resize(size, 0);
      chunk = last;
    }
    shuffle(chunk.first(size), array.value_size, planes);
    deflater.start(size, array.value_size);
    for (std::size_t k = 0; k < array.value_size; ++k) {
      const auto plane = std::span(planes).subspan(k * plane_size, plane_size);
      deflater.add(plane, array.real && is_noise(plane) ? stored_level : fast_level);
    }
    chunks.push_back(deflater.finish());
  }
  return chunks;
}

KeptChunks::KeptChunks(const std::vector<std::string>& datasets) {
  for (const std::string& dataset : datasets) kept_[dataset];
}

std::shared_ptr<const PressedChunks> KeptChunks::press(const std::string& dataset,
                                                       const ArrayBytes& array,
                                                       std::size_t chunk_rows) {
  const auto kept = kept_.find(dataset);
  if (kept != kept_.end() && kept->second.chunks && kept->second.row_size == array.row_size &&
      std::ranges::equal(kept->second.bytes, array.bytes)) {
    return kept->second.chunks;
  }
  auto chunks = std::make_shared<const PressedChunks>(press_chunks(array, chunk_rows));
  if (kept == kept_.end()) return chunks;
  if (kept->second.chunks) {
    kept_.erase(kept);
  } else {
    kept->second = {.bytes = {array.bytes.begin(), array.bytes.end()},
                    .row_size = array.row_size,
                    .chunks = chunks};
  }
  return chunks;
}

}  // namespace gabion
