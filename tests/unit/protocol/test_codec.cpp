// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <array>
#include <atomic>
#include <bit>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <limits>
#include <new>
#include <random>
#include <sstream>

#include "protocol/wire/codec.hpp"
#include "protocol/wire/exchange.hpp"
#include "tests/support/expect_error.hpp"

namespace {
// Bytes asked of the heap since the last reset: an upper bound of what decoding holds at once.
std::atomic<std::size_t> allocated = 0;
}  // namespace

// Not inlined: the compiler would take malloc and delete for a mismatched pair.
[[gnu::noinline]] void* operator new(std::size_t size) {
  allocated += size;
  if (void* memory = std::malloc(size == 0 ? 1 : size)) return memory;
  throw std::bad_alloc();
}
[[gnu::noinline]] void operator delete(void* memory) noexcept {
  std::free(memory);
}
[[gnu::noinline]] void operator delete(void* memory, std::size_t) noexcept {
  std::free(memory);
}

namespace gabion::test_codec {
namespace {

using test::expect_error, test::expect_parts;

using Frames = std::vector<std::string>;

Frames frames_of(const Message& message) {
  const EncodedMessage encoded = encode(message);
  Frames frames = {encoded.header};
  for (const auto payload : encoded.payloads) frames.emplace_back(payload);
  return frames;
}

template <class Value>
void expect_same_bits(const std::vector<Value>& a, const std::vector<Value>& b) {
  ASSERT_EQ(a.size(), b.size());
  EXPECT_TRUE(a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(Value)) == 0);
}

std::string refusal_of(const Frames& frames, const CodecLimits& limits = {}) {
  try {
    decode(frames, limits);
  } catch (const ProtocolError& problem) {
    return problem.what();
  }
  return "";
}

#define EXPECT_REFUSED(frames, part) \
  EXPECT_NE(refusal_of(frames).find(part), std::string::npos) << refusal_of(frames)

TEST(Codec, arrays_round_trip_bits) {
  Message message;
  message.type = "solved";
  message.sequence = std::numeric_limits<std::uint64_t>::max();
  std::vector<double> special = {0.0,
                                 -0.0,
                                 std::numeric_limits<double>::denorm_min(),
                                 -1e-310,
                                 std::numeric_limits<double>::max(),
                                 1. / 3,
                                 std::numeric_limits<double>::infinity(),
                                 std::nan("7")};
  std::vector<double> large(1000000);
  std::mt19937_64 random(1);
  for (double& value : large) value = std::bit_cast<double>(random());
  const std::vector<std::int64_t> integers = {std::numeric_limits<std::int64_t>::min(), -1, 0, 1,
                                              std::numeric_limits<std::int64_t>::max(), 5};
  message.add("special", {4, 2}, special);
  message.add("none", {0, 3}, std::vector<double>());
  message.add("large", {1000000}, large);
  message.add("integers", {3, 2}, integers);
  message.add("no integers", {3, 0}, std::vector<std::int64_t>());

  const Message back = decode(frames_of(message));
  EXPECT_EQ(back.type, "solved");
  EXPECT_EQ(back.sequence, message.sequence);
  expect_same_bits(back.reals("special", {4, 2}), special);
  expect_same_bits(back.reals("large", {-1}), large);
  expect_same_bits(back.integers("integers", {-1, 2}), integers);
  EXPECT_TRUE(back.reals("none", {0, 3}).empty());
  EXPECT_TRUE(back.integers("no integers", {3, 0}).empty());
}

TEST(Codec, header_numbers_round_trip_bits) {
  std::mt19937_64 random(2);
  for (int i = 0; i < 20000; ++i) {
    const double value = std::bit_cast<double>(random());
    if (!std::isfinite(value)) continue;
    Message message;
    message.type = "solve_step";
    message.fields["time"] = value;
    const double back = decode(frames_of(message)).number("time");
    ASSERT_EQ(std::bit_cast<std::uint64_t>(back), std::bit_cast<std::uint64_t>(value)) << value;
  }
}

TEST(Codec, fields_of_every_kind_round_trip) {
  Message message;
  message.type = "welcome";
  message.fields = {
      {"a", true}, {"b", "Geröll \"\\ \n"}, {"c", {{"d", Json::array({1, nullptr})}}}, {"e", -3}};
  EXPECT_EQ(decode(frames_of(message)).fields, message.fields);
}

TEST(Codec, text_that_is_not_utf8_is_still_sent) {
  Message message;
  message.type = "abort";
  message.fields["reason"] = "file \xff\xfe missing";
  EXPECT_NE(decode(frames_of(message)).text("reason").find("missing"), std::string::npos);
}

TEST(Codec, coupled_step_round_trips) {
  Message message;
  const StepRequest request{57, 3, 0.1 + 0.2, 1e-4 / 3};
  put(message, request);
  const StepRequest back = read_step_request(decode(frames_of([&] {
    message.type = "solve_step";
    return message;
  }())));
  EXPECT_EQ(back.step, 57);
  EXPECT_EQ(back.iteration, 3);
  EXPECT_EQ(back.time, request.time);
  EXPECT_EQ(back.dt, request.dt);
  EXPECT_EQ(describe(message), "solve_step 57 iteration 3");
}

std::string header(const std::string& arrays) {
  return fmt::format(R"({{"type":"solved","sequence":1,"arrays":{}}})", arrays);
}
std::string one_array(const std::string& shape, const std::string& dtype = "<f8") {
  return header(fmt::format(R"([{{"name":"x","dtype":"{}","shape":{}}}])", dtype, shape));
}

/// Frames from the hex dumps of README.md section 12, in their order.
Frames readme_frames() {
  std::ifstream readme(GABION_PROTOCOL_README);
  Frames frames;
  bool in_dump = false;
  for (std::string line; std::getline(readme, line);) {
    const bool dump = line.size() > 57 && line.starts_with("    0") && line.substr(8, 2) == "  ";
    if (dump && !in_dump) frames.emplace_back();
    in_dump = dump;
    if (!dump) continue;
    std::istringstream bytes(line.substr(10, 47));
    for (std::string byte; bytes >> byte;) {
      frames.back() += static_cast<char>(std::stoi(byte, nullptr, 16));
    }
  }
  return frames;
}

TEST(Codec, worked_example_of_the_readme_is_true) {
  const Frames frames = readme_frames();
  ASSERT_EQ(frames.size(), 4u);
  const Message request = decode(Frames{frames[0], frames[1]});
  EXPECT_EQ(request.type, "solve_step");
  EXPECT_EQ(request.sequence, 7u);
  EXPECT_EQ(read_step_request(request).step, 3);
  EXPECT_EQ(read_step_request(request).dt, 0.001);
  EXPECT_EQ(request.reals("displacement:wall", {2, 2}), (std::vector<double>{0, 0, 1e-3, -5e-4}));
  EXPECT_EQ(frames_of(request), (Frames{frames[0], frames[1]}));
  const Message reply = decode(Frames{frames[2], frames[3]});
  EXPECT_EQ(read_step_report(reply).newton_iterations, 4);
  EXPECT_EQ(reply.reals("force:wall", {2, 2}), (std::vector<double>{1, 0, 250, -12.5}));
  EXPECT_EQ(frames_of(reply), (Frames{frames[2], frames[3]}));
}

TEST(Codec, broken_frames_are_refused) {
  const std::string two_values(16, '\0');
  EXPECT_EQ(refusal_of({one_array("[2]"), two_values}), "");
  EXPECT_REFUSED(Frames{}, "without frames");
  EXPECT_REFUSED(Frames{""}, "not JSON");
  EXPECT_REFUSED(Frames{"\xff\xff"}, "not JSON");
  EXPECT_REFUSED(Frames{"[1]"}, "expected a JSON object");
  EXPECT_REFUSED(Frames{R"({"sequence":1})"}, "\"type\"");
  EXPECT_REFUSED(Frames{R"({"type":"x","sequence":-1})"}, "\"sequence\"");
  EXPECT_REFUSED(Frames{R"({"type":"x","sequence":1e999})"}, "not JSON");
  EXPECT_REFUSED(Frames{std::string(100, '[')}, "nested deeper");
  EXPECT_REFUSED(Frames{std::string((1 << 20) + 1, ' ')}, "exceeds the limit");
  EXPECT_REFUSED(Frames{header("7")}, "is no list");
  EXPECT_REFUSED(Frames{one_array("[2]")}, "describes 1 arrays, found 0 frames");
  EXPECT_REFUSED((Frames{header("[]"), two_values}), "describes 0 arrays, found 1 frames");
  EXPECT_REFUSED((Frames{one_array("[3]"), two_values}), "expected a frame of 24 bytes, found 16");
  EXPECT_REFUSED((Frames{one_array("[2]"), std::string(15, 'x')}), "found 15");
  EXPECT_REFUSED((Frames{one_array("[-2]"), two_values}), "negative extent");
  EXPECT_REFUSED((Frames{one_array("[1.5]"), two_values}), "integer extents");
  EXPECT_REFUSED((Frames{one_array("[]"), two_values}), "1 to 4 extents");
  EXPECT_REFUSED((Frames{one_array("[1,1,1,1,2]"), two_values}), "1 to 4 extents");
  EXPECT_REFUSED((Frames{one_array("[2]", ">f8"), two_values}), "expected dtype");
  // Products that wrap to 16 bytes in 64-bit arithmetic.
  EXPECT_REFUSED((Frames{one_array("[2305843009213693954]"), two_values}), "exceeds the limit");
  EXPECT_REFUSED((Frames{one_array("[4294967296,4294967296,2]"), two_values}), "exceeds the limit");
  EXPECT_REFUSED((Frames{one_array("[18446744073709551615]"), two_values}), "integer extents");
  EXPECT_REFUSED((Frames{one_array("[0,9223372036854775807]"), two_values}), "exceeds the limit");
  const std::string entry = R"({"name":"x","dtype":"<f8","shape":[2]})";
  EXPECT_REFUSED((Frames{header(fmt::format("[{0},{0}]", entry)), two_values, two_values}),
                 "twice");
}

TEST(Codec, limits_hold_on_both_sides) {
  CodecLimits small;
  small.max_arrays = 1;
  small.max_payload_bytes = 24;
  small.max_frame_bytes = 24;
  Message message;
  message.type = "solved";
  message.add("x", {4}, std::vector<double>(4));
  expect_error<ProtocolError>([&] { encode(message, small); }, {"exceeds the limit of 24 bytes"});
  expect_parts(refusal_of(frames_of(message), small), {"exceeds the limit of 24 bytes"});
  message.arrays.clear();
  message.add("x", {1}, std::vector<double>(1));
  message.add("y", {1}, std::vector<double>(1));
  expect_error<ProtocolError>([&] { encode(message, small); }, {"2 arrays exceed the limit of 1"});
  expect_parts(refusal_of(frames_of(message), small), {"2 arrays exceed the limit of 1"});
  message.arrays.pop_back();
  EXPECT_EQ(refusal_of(frames_of(message), small), "");
}

TEST(Codec, encode_refuses_shape_that_does_not_fit) {
  Message message;
  message.type = "solved";
  message.add("x", {3, 2}, std::vector<double>(5));
  expect_error<ProtocolError>([&] { encode(message); }, {"\"x\": shape [3, 2] but 5 values"});
}

TEST(Codec, typed_access_names_field_and_finding) {
  Message message;
  message.type = "solve_step";
  message.fields = {{"dt", nullptr}, {"step", 1.5}, {"time", -1.0}};
  const auto text = [](auto action) {
    try {
      action();
    } catch (const ProtocolError& problem) {
      return std::string(problem.what());
    }
    return std::string();
  };
  EXPECT_EQ(text([&] { message.number("dt"); }),
            "message \"solve_step\", field \"dt\": expected a number, found null");
  EXPECT_NE(text([&] { message.integer("step"); }).find("found 1.5"), std::string::npos);
  EXPECT_NE(text([&] { message.integer("iteration"); }).find("found nothing"), std::string::npos);
  EXPECT_NE(text([&] { message.positive_number("time"); }).find("> 0"), std::string::npos);
  message.add("x", {2}, std::vector<double>(2));
  EXPECT_NE(text([&] { message.reals("x", {3}); }).find("expected shape [3], found [2]"),
            std::string::npos);
  EXPECT_NE(text([&] { message.integers("x", {2}); }).find("found \"<f8\""), std::string::npos);
}

TEST(Codec, non_finite_values_are_found) {
  std::vector<double> values(6, 1.0);
  EXPECT_NO_THROW(require_finite(values, 2, "force:wall"));
  values[5] = std::numeric_limits<double>::quiet_NaN();
  try {
    require_finite(values, 2, "force:wall");
    FAIL();
  } catch (const ProtocolError& problem) {
    EXPECT_STREQ(problem.what(),
                 "\"force:wall\" is nan at vertex 2, component 1: values must be finite");
  }
}

// Any bytes: decode returns a message or throws ProtocolError, and stays inside its memory bound.
TEST(Codec, mutated_frames_never_crash_nor_exceed_the_memory_bound) {
  Message message;
  message.type = "solved";
  message.fields = {{"details", {{"energy", 1.25}, {"list", {1, 2, 3}}}}, {"busy_seconds", 0.1}};
  message.add("force:wall", {5, 2}, std::vector<double>(10, 1.5));
  message.add("facets:wall", {4, 2}, std::vector<std::int64_t>(8, 1));
  const Frames good = frames_of(message);
  const std::string alphabet = "{}[]\",:0123456789-eE.<fi8tn\\u \xff\x00";
  std::mt19937_64 random(3);
  const auto below = [&random](std::size_t n) { return static_cast<std::size_t>(random() % n); };
  int whole = 0;
  for (int i = 0; i < 100000; ++i) {
    Frames frames = good;
    for (std::size_t k = 1 + below(4); k > 0; --k) {
      std::string& frame = frames[below(10) < 8 ? 0 : below(frames.size())];
      const std::size_t at = below(frame.size() + 1);
      switch (below(5)) {
        case 0:
          if (at < frame.size()) frame[at] = static_cast<char>(random());
          break;
        case 1:
          if (at < frame.size()) frame[at] = alphabet[below(alphabet.size())];
          break;
        case 2:
          frame.erase(at, 1 + below(8));
          break;
        case 3:
          frame.insert(at, frame.substr(below(frame.size() + 1), below(40)));
          break;
        case 4:
          if (below(50) == 0) frames.resize(1 + below(frames.size()));
          break;
      }
    }
    std::size_t payload = 0;
    for (std::size_t k = 1; k < frames.size(); ++k) payload += frames[k].size();
    const std::size_t bound = 64 * frames[0].size() + payload + 4096;
    allocated = 0;
    try {
      decode(frames);
      ++whole;
    } catch (const ProtocolError&) {
    }
    ASSERT_LE(allocated, bound) << frames[0];
  }
  EXPECT_GT(whole, 100);    // the mutations are not all hopeless
  EXPECT_LT(whole, 60000);  // nor all harmless
}

TEST(Codec, worst_headers_stay_inside_the_memory_bound) {
  for (const std::string& unit :
       {std::string("[],"), std::string("{},"), std::string("0,"), std::string("\"\",")}) {
    std::string list;
    while (list.size() < 500000) list += unit;
    list.pop_back();
    const Frames frames = {fmt::format(R"({{"type":"x","sequence":1,"l":[{}]}})", list)};
    allocated = 0;
    EXPECT_EQ(refusal_of(frames), "");
    EXPECT_LE(allocated, 64 * frames[0].size()) << unit;
  }
  std::string members;
  for (int i = 0; members.size() < 500000; ++i) members += fmt::format("\"{}\":0,", i);
  members.pop_back();
  const Frames frames = {fmt::format(R"({{"type":"x","sequence":1,"l":{{{}}}}})", members)};
  allocated = 0;
  EXPECT_EQ(refusal_of(frames), "");
  EXPECT_LE(allocated, 64 * frames[0].size());
}

}  // namespace
}  // namespace gabion::test_codec
