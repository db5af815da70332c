// SPDX-License-Identifier: BSD-3-Clause
#include "mutator.hpp"

#include <algorithm>
#include <array>
#include <cstring>
#include <fstream>
#include <limits>
#include <string_view>

#include "common/base/require.hpp"

namespace gabion::fuzz {
namespace {

/// Values over which parsers and size computations stumble.
constexpr std::array<std::string_view, 34> tokens = {"null",
                                                     "true",
                                                     "-1",
                                                     "0",
                                                     "-0",
                                                     "1e999",
                                                     "1e-999",
                                                     "-0.0",
                                                     "0.1e1",
                                                     "01",
                                                     "1.",
                                                     ".5",
                                                     "2147483648",
                                                     "9223372036854775807",
                                                     "9223372036854775808",
                                                     "18446744073709551615",
                                                     "18446744073709551616",
                                                     "1152921504606846976",
                                                     "NaN",
                                                     "Infinity",
                                                     "[",
                                                     "]",
                                                     "{",
                                                     "}",
                                                     "\"",
                                                     "\\",
                                                     "\\ud800",
                                                     "\\u0000",
                                                     "\xFF",
                                                     "\xEF\xBB\xBF",
                                                     ",",
                                                     ":",
                                                     "\"<i8\"",
                                                     "\"arrays\":[]"};

std::string bytes_of(const std::string& hex) {
  std::string bytes;
  for (std::size_t i = 0; i + 1 < hex.size(); i += 2) {
    bytes += static_cast<char>(std::stoi(hex.substr(i, 2), nullptr, 16));
  }
  return bytes;
}

std::string token(Random& random) {
  if (random.one_in(20)) {
    std::string digits(1 + random.below(5000), '0');
    digits[0] = '1';
    return digits;
  }
  return std::string(tokens[random.below(tokens.size())]);
}

/// One change of any bytes.
void spoil_bytes(std::string& bytes, Random& random) {
  const std::size_t at = random.below(bytes.size() + 1);
  const std::size_t length = random.below(bytes.size() - at + 1);
  switch (random.below(7)) {
    case 0:
      if (at < bytes.size()) bytes[at] = static_cast<char>(bytes[at] ^ (1 << random.below(8)));
      break;
    case 1:
      if (at < bytes.size()) bytes[at] = static_cast<char>(random.below(256));
      break;
    case 2:
      bytes.insert(at, token(random));
      break;
    case 3:
      bytes.erase(at, std::min<std::size_t>(length, 1 + random.below(16)));
      break;
    case 4:
      bytes.resize(at);
      break;
    case 5:
      bytes.insert(at, bytes.substr(at, length));
      break;
    default:
      bytes.replace(at, std::min<std::size_t>(length, 8), token(random));
      break;
  }
}

/// A JSON value of any kind, now and then nested or large.
Json any_value(Random& random, int depth = 0) {
  switch (random.below(depth < 3 ? 12 : 9)) {
    case 0:
      return nullptr;
    case 1:
      return random.one_in(2);
    case 2:
      return static_cast<std::int64_t>(random.below(8)) - 1;
    case 3:
      return random.next();
    case 4:
      return std::numeric_limits<std::int64_t>::min();
    case 5:
      return std::int64_t{1} << random.below(63);
    case 6:
      return 1.0 / static_cast<double>(1 + random.below(7));
    case 7:
      return std::numeric_limits<double>::max();
    case 8:
      return std::string(random.below(70), static_cast<char>('a' + random.below(26)));
    case 9:
      return Json::array({any_value(random, depth + 1), any_value(random, depth + 1)});
    case 10:
      return {{random.one_in(2) ? "name" : "x", any_value(random, depth + 1)}};
    default: {
      Json deep = 1;
      for (std::size_t i = random.below(40); i > 0; --i) deep = Json::array({deep});
      return deep;
    }
  }
}

/// A random value of a header, at any depth.
Json& any_place(Json& root, Random& random) {
  Json* at = &root;
  while (at->is_structured() && !at->empty() && !(at != &root && random.one_in(3))) {
    auto step = at->begin();
    std::advance(step, static_cast<std::ptrdiff_t>(random.below(at->size())));
    at = &*step;
  }
  return *at;
}

/// One change that leaves the header JSON.
void spoil_structure(Json& header, const std::vector<Json>& others, Random& random) {
  Json& place = any_place(header, random);
  switch (random.below(6)) {
    case 0:
      place = any_value(random);
      break;
    case 1: {
      Json other = others[random.below(others.size())];
      place = any_place(other, random);
      break;
    }
    case 2:
      if (place.is_array() && random.one_in(2)) {
        for (Json& element : place)
          element = random.one_in(2) ? 0 : std::int64_t{1} << random.below(63);
        place.push_back(std::int64_t{1} << random.below(63));
      } else if (place.is_structured()) {
        place.clear();
      }
      break;
    case 3:
      if (place.is_array()) place.push_back(place.empty() ? any_value(random) : place.back());
      if (place.is_object()) place[random.one_in(2) ? "arrays" : "shape"] = any_value(random);
      break;
    case 4:
      if (header.is_object() && !header.empty()) {
        auto gone = header.begin();
        std::advance(gone, static_cast<std::ptrdiff_t>(random.below(header.size())));
        header.erase(gone);
      }
      break;
    default:
      if (place.is_number_integer()) {
        place =
            place.get<std::uint64_t>() + (random.one_in(2) ? std::uint64_t{1} : ~std::uint64_t{0});
      }
      break;
  }
}

void spoil_payload(Frames& frames, const std::vector<Frames>& corpus, Random& random) {
  const std::size_t at = 1 + random.below(frames.size());
  const auto where = frames.begin() + static_cast<std::ptrdiff_t>(std::min(at, frames.size()));
  const bool there = where != frames.end();
  switch (random.below(7)) {
    case 0:
      if (there) frames.erase(where);
      break;
    case 1:
      frames.insert(where, std::string(8 * random.below(5), '\0'));
      break;
    case 2:
      if (there) where->resize(random.below(2 * where->size() + 2));
      break;
    case 3:
      if (there && where->size() >= 8) {
        const double bad = random.one_in(2) ? std::numeric_limits<double>::quiet_NaN()
                                            : -std::numeric_limits<double>::infinity();
        std::memcpy(where->data() + 8 * random.below(where->size() / 8), &bad, 8);
      }
      break;
    case 4:
      frames.insert(where, 1 + random.below(300), there ? *where : "");
      break;
    case 5:
      frames.insert(where, corpus[random.below(corpus.size())].back());
      break;
    default:
      if (there && !where->empty()) spoil_bytes(*where, random);
      break;
  }
}

}  // namespace

std::vector<Frames> read_seeds(const std::string& folder) {
  std::vector<Frames> seeds;
  for (const char* name : {"accepted.json", "refused.json"}) {
    std::ifstream in(folder + "/" + name);
    require(in.good(), folder + "/" + name + ": cannot be read");
    for (const Json& vector : Json::parse(in)) {
      Frames frames = {vector.contains("header_hex") ? bytes_of(vector["header_hex"])
                                                     : vector["header"].get<std::string>()};
      for (const Json& payload : vector["payloads"]) frames.push_back(bytes_of(payload));
      // Frames that are refused at once reach little code.
      seeds.insert(seeds.end(), vector.contains("message") ? 20 : 1, frames);
    }
  }
  return seeds;
}

std::uint64_t Random::next() {
  std::uint64_t z = state_ += 0x9E3779B97F4A7C15U;
  z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9U;
  z = (z ^ (z >> 27)) * 0x94D049BB133111EBU;
  return z ^ (z >> 31);
}

Mutator::Mutator(std::vector<Frames> corpus, std::uint64_t seed)
    : corpus_(std::move(corpus)), seed_(seed) {
  for (const Frames& frames : corpus_) {
    Json header = Json::parse(frames[0], nullptr, false);
    headers_.push_back(header.is_discarded() ? Json::object() : std::move(header));
  }
}

Frames Mutator::input(std::uint64_t index) const {
  Random random(Random(seed_).next() ^ (index * 0xD1342543DE82EF95U));
  const std::size_t from = random.below(corpus_.size());
  Frames frames = corpus_[from];
  if (random.one_in(2)) {
    Json header = headers_[from];
    for (std::size_t i = 1 + random.below(3); i > 0; --i) spoil_structure(header, headers_, random);
    frames[0] = header.dump(-1, ' ', false, Json::error_handler_t::replace);
  }
  if (random.one_in(3)) spoil_payload(frames, corpus_, random);
  if (random.one_in(3)) {
    for (std::size_t i = 1 + random.below(4); i > 0; --i) spoil_bytes(frames[0], random);
  }
  if (random.one_in(1000)) frames.clear();
  return frames;
}

}  // namespace gabion::fuzz
