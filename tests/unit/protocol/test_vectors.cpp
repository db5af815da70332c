// SPDX-License-Identifier: BSD-3-Clause
// The vectors of protocol/test_vectors, which the Python side reads too.
#include <gtest/gtest.h>

#include <cstring>
#include <fstream>

#include "protocol/wire/codec.hpp"
#include "protocol/wire/exchange.hpp"
#include "tests/support/expect_error.hpp"

namespace gabion::test_vectors {
namespace {

using test::expect_error;

Json read_vectors(const std::string& name) {
  std::ifstream in(GABION_TEST_VECTORS "/" + name);
  return Json::parse(in);
}

std::string bytes_of(const std::string& hex) {
  std::string bytes;
  for (std::size_t i = 0; i < hex.size(); i += 2) {
    bytes += static_cast<char>(std::stoi(hex.substr(i, 2), nullptr, 16));
  }
  return bytes;
}

std::vector<std::string> frames_of(const Json& vector) {
  std::vector<std::string> frames = {vector.contains("header_hex")
                                         ? bytes_of(vector["header_hex"])
                                         : vector["header"].get<std::string>()};
  for (const Json& payload : vector["payloads"]) frames.push_back(bytes_of(payload));
  return frames;
}

double real(const Json& value) {
  return value.is_string() ? std::stod(value.get<std::string>()) : value.get<double>();
}

Message message_of(const Json& described) {
  Message message{.type = described["type"],
                  .sequence = described["sequence"],
                  .fields = described["fields"],
                  .arrays = {}};
  for (const Json& array : described["arrays"]) {
    const std::vector<std::int64_t> shape = array["shape"];
    if (array["dtype"] == "<i8") {
      message.add(array["name"], shape, array["values"].get<std::vector<std::int64_t>>());
      continue;
    }
    std::vector<double> values;
    for (const Json& value : array["values"]) values.push_back(real(value));
    message.add(array["name"], shape, values);
  }
  return message;
}

template <class Value>
bool same_bits(const std::vector<Value>& a, const std::vector<Value>& b) {
  return a.size() == b.size() &&
         (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(Value)) == 0);
}

TEST(Vectors, encode_to_these_bytes) {
  for (const Json& vector : read_vectors("accepted.json")) {
    SCOPED_TRACE(vector["name"]);
    const Message message = message_of(vector["message"]);
    const EncodedMessage encoded = encode(message);
    std::vector<std::string> frames = {encoded.header};
    frames.insert(frames.end(), encoded.payloads.begin(), encoded.payloads.end());
    EXPECT_EQ(frames, frames_of(vector));
  }
}

TEST(Vectors, decode_to_this_content) {
  for (const Json& vector : read_vectors("accepted.json")) {
    SCOPED_TRACE(vector["name"]);
    const Message expected = message_of(vector["message"]);
    const Message found = decode(frames_of(vector));
    EXPECT_EQ(found.type, expected.type);
    EXPECT_EQ(found.sequence, expected.sequence);
    EXPECT_EQ(found.fields, expected.fields);
    ASSERT_EQ(found.arrays.size(), expected.arrays.size());
    for (std::size_t i = 0; i < found.arrays.size(); ++i) {
      EXPECT_EQ(found.arrays[i].name, expected.arrays[i].name);
      EXPECT_EQ(found.arrays[i].shape, expected.arrays[i].shape);
      ASSERT_EQ(found.arrays[i].values.index(), expected.arrays[i].values.index());
      std::visit(
          [&](const auto& values) {
            using Values = std::decay_t<decltype(values)>;
            EXPECT_TRUE(same_bits(values, std::get<Values>(expected.arrays[i].values)));
          },
          found.arrays[i].values);
    }
  }
}

TEST(Vectors, bytes_of_a_state) {
  int count = 0;
  for (const Json& vector : read_vectors("accepted.json")) {
    if (!vector.contains("bytes")) continue;
    SCOPED_TRACE(vector["name"]);
    ++count;
    const std::string text = bytes_of(vector["bytes"]);
    const auto* first = reinterpret_cast<const std::byte*>(text.data());
    const std::vector<std::byte> bytes(first, first + text.size());
    const State expected = read_state(message_of(vector["message"]));
    const State found = pack_bytes(bytes);
    EXPECT_EQ(found.facts, expected.facts);
    EXPECT_EQ(found.integers, expected.integers);
    EXPECT_EQ(unpack_bytes(expected), bytes);
  }
  EXPECT_EQ(count, 3);
}

TEST(Vectors, bytes_that_are_not_as_many_as_said) {
  for (const auto& [bytes, values] : std::vector<std::pair<Json, std::size_t>>{
           {9u, 1}, {8u, 2}, {1u, 0}, {0u, 1}, {1ull << 62, 1}, {-1, 1}, {"8", 1}}) {
    State state;
    state.facts["bytes"] = bytes;
    state.integers["bytes"].resize(values);
    expect_error<ProtocolError>(
        [&] { unpack_bytes(state); },
        {"expected an array of " + bytes.dump() + " bytes, found " + std::to_string(values)});
  }
  expect_error<ProtocolError>([] { unpack_bytes(State{}); },
                              {"expected an array of null bytes, found 0 values"});
}

TEST(Vectors, malformed_frames_are_refused) {
  const Json vectors = read_vectors("refused.json");
  EXPECT_GT(vectors.size(), 40u);
  for (const Json& vector : vectors) {
    SCOPED_TRACE(vector["name"]);
    expect_error<ProtocolError>([&] { decode(frames_of(vector)); },
                                {vector["says"].get<std::string>()});
  }
}

}  // namespace
}  // namespace gabion::test_vectors
