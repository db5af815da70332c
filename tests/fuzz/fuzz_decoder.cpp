// SPDX-License-Identifier: BSD-3-Clause
// Spoilt frames for the decoder and for all that reads its messages. Whatever comes, the answer is
// a ProtocolError, or a message that survives another round through the codec.
//
//     fuzz_decoder --vectors protocol/test_vectors [--seed 1] [--first 0] [--count N] [--seconds S]
//                  [--write FILE]
//
// Ends with 1 at the first input that breaks this, and with its number: `--first NUMBER --count 1`
// repeats it. With a sanitizer, its report follows the number. `--write` lists inputs and verdicts,
// one JSON object a line, for decoders in other languages.
#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <optional>

#include "common/base/timer.hpp"
#include "mutator.hpp"
#include "protocol/wire/codec.hpp"
#include "protocol/wire/exchange.hpp"
#include "protocol/wire/handshake.hpp"

// The handler below has to learn of what a sanitizer finds.
extern "C" const char* __asan_default_options();
extern "C" const char* __asan_default_options() {
  return "abort_on_error=1:detect_leaks=1";
}
extern "C" const char* __ubsan_default_options();
extern "C" const char* __ubsan_default_options() {
  return "halt_on_error=1:abort_on_error=1:print_stacktrace=1";
}

namespace {

using namespace gabion;
using fuzz::Frames;

volatile sig_atomic_t number_length = 0;
char number_text[64];  // of the input under way, for a handler that may not allocate

extern "C" void name_input(int signal) {
  const char text[] = "fuzz_decoder: died on input ";
  if (write(STDERR_FILENO, text, sizeof text - 1) < 0 ||
      write(STDERR_FILENO, number_text, static_cast<std::size_t>(number_length)) < 0) {
    _exit(1);
  }
  std::signal(signal, SIG_DFL);
  std::raise(signal);
}

void announce(std::uint64_t number) {
  const auto end = fmt::format_to_n(number_text, sizeof number_text - 1, "{}\n", number);
  number_length = static_cast<sig_atomic_t>(end.size);
}

template <class Value>
bool same_bits(const std::vector<Value>& a, const std::vector<Value>& b) {
  return a.size() == b.size() &&
         (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(Value)) == 0);
}

bool same(const Message& a, const Message& b) {
  if (a.type != b.type || a.sequence != b.sequence || a.fields != b.fields) return false;
  if (a.arrays.size() != b.arrays.size()) return false;
  for (std::size_t i = 0; i < a.arrays.size(); ++i) {
    const Array& x = a.arrays[i];
    const Array& y = b.arrays[i];
    if (x.name != y.name || x.shape != y.shape || x.values.index() != y.values.index())
      return false;
    const bool equal = std::visit(
        [&y](const auto& values) {
          return same_bits(values, std::get<std::decay_t<decltype(values)>>(y.values));
        },
        x.values);
    if (!equal) return false;
  }
  return true;
}

/// Every reader of a message's content: an answer or a ProtocolError.
void read_content(const Message& message) {
  const auto attempt = [](auto read) {
    try {
      read();
    } catch (const ProtocolError&) {
      // The exception that a reader is allowed to throw.
    }
  };
  attempt([&] {
    const Hello hello = read_hello(message);
    compare({}, hello);
    major_version(hello.protocol);
    to_message(hello);
  });
  attempt([&] { read_welcome(message); });
  attempt([&] { describe(message); });
  attempt([&] { read_step_request(message); });
  attempt([&] { read_step_report(message); });
  attempt([&] { read_accept_report(message, 1); });
  attempt([&] { unpack_bytes(read_state(message)); });
  const std::vector<InterfaceMesh> wall = {{"wall", 2, {0, 0, 0, 1}, 2, {0, 1}}};
  attempt([&] { read_values(message, "force", wall); });
  attempt([&] { read_values(message, "displacement", wall); });
}

bool is_utf8(const std::string& text) {
  try {
    static_cast<void>(Json(text).dump());
    return true;
  } catch (const Json::exception&) {
    return false;
  }
}

/// Whether the input was accepted. What is wrong otherwise goes to `defect`.
bool check(const Frames& frames, std::string& defect) {
  std::optional<Message> message;
  try {
    message = decode(frames);
  } catch (const ProtocolError& refused) {
    // The text goes to logs and JSON files.
    if (!is_utf8(refused.what())) defect = "the error's text is not UTF-8";
    return false;
  } catch (const std::exception& other) {
    defect = fmt::format("decode threw something else: {}", other.what());
    return false;
  }
  try {
    read_content(*message);
    const EncodedMessage encoded = encode(*message);
    Frames again = {encoded.header};
    again.insert(again.end(), encoded.payloads.begin(), encoded.payloads.end());
    if (!same(decode(again), *message)) defect = "a second round changed the message";
  } catch (const std::exception& problem) {
    defect = fmt::format("an accepted message cannot be used: {}", problem.what());
  }
  return true;
}

std::string hex_of(const std::string& bytes) {
  std::string text;
  for (const char c : bytes) text += fmt::format("{:02x}", static_cast<unsigned char>(c));
  return text;
}

Json described(const Frames& frames) {
  Json list = Json::array();
  for (const std::string& frame : frames) list.push_back(hex_of(frame));
  return list;
}

}  // namespace

int main(int argc, char** argv) {
  std::string vectors;
  std::string list;
  std::uint64_t seed = 1;
  std::uint64_t first = 0;
  std::uint64_t count = 1'000'000'000'000;
  double seconds = 1e9;
  CLI::App app("Spoilt frames for the decoder of the protocol.");
  app.add_option("--vectors", vectors, "Folder of the test vectors")->required();
  app.add_option("--seed", seed, "Another seed, other inputs")->capture_default_str();
  app.add_option("--first", first, "Number of the first input")->capture_default_str();
  app.add_option("--count", count, "Inputs at most");
  app.add_option("--seconds", seconds, "Seconds at most")->check(CLI::PositiveNumber);
  app.add_option("--write", list, "Write inputs and verdicts to this file");
  CLI11_PARSE(app, argc, argv);
  for (const int signal : {SIGABRT, SIGFPE, SIGILL}) std::signal(signal, name_input);

  const fuzz::Mutator mutator(fuzz::read_seeds(vectors), seed);
  std::ofstream out;
  if (!list.empty()) out.open(list);
  const Stopwatch watch;
  std::uint64_t accepted = 0;
  std::uint64_t number = first;
  for (; number - first < count && watch.seconds() < seconds; ++number) {
    announce(number);
    const Frames frames = mutator.input(number);
    std::string defect;
    const bool taken = check(frames, defect);
    accepted += taken ? 1 : 0;
    if (!list.empty()) out << Json{{"frames", described(frames)}, {"accepted", taken}} << '\n';
    if (!defect.empty()) {
      fmt::print("input {} of seed {}: {}\n{}\n", number, seed, defect, described(frames).dump());
      return 1;
    }
  }
  fmt::print("{} inputs of seed {} in {:.1f} s: {} accepted, {} refused\n", number - first, seed,
             watch.seconds(), accepted, number - first - accepted);
  if (accepted == 0 || accepted == number - first) {
    fmt::print("both kinds should occur: the inputs test nothing\n");
    return 1;
  }
  return out.fail() ? 1 : 0;
}
