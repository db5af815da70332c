// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <fmt/format.h>

#include <limits>
#include <optional>
#include <span>

#include "common/base/timer.hpp"
#include "fake_solver.hpp"
#include "protocol/channel/socket.hpp"
#include "protocol/wire/codec.hpp"
#include "protocol/wire/exchange.hpp"
#include "protocol/wire/handshake.hpp"

namespace gabion::test {

/// A participant on a bare socket, without heartbeat, that says one wrong thing:
///   garbage, truncated, lost_frame, wrong_sizes, nan, wrong_sequence, wrong_type
///   refused_scene (handshake only)
/// In the phases before and after a solution it says it without being asked.
class Liar {
 public:
  /// @param patience  for the answer to its hello [s]
  Liar(const std::string& endpoint, Hello hello, Misdeed misdeed, double patience)
      : socket_(Socket::connect_dealer(make_socket_context(), endpoint,
                                       hello.participant + "#" + hello.session)),
        hello_(std::move(hello)),
        misdeed_(std::move(misdeed)),
        patience_(patience),
        solver_(hello_.participant == "soil", {}, 0) {}

  /// Run until the coupler says "refused", "abort" (1) or "finish" (0), or nothing for long (3).
  int run() {
    if (misdeed_.kind == "refused_scene") hello_.scene_hash = "0123";
    say(to_message(hello_), "handshake");
    const Message answer = receive(patience_);
    std::puts(fmt::format("{} {}", answer.type, answer.fields.dump()).c_str());
    std::fflush(stdout);
    if (answer.type != "welcome") return answer.type.empty() ? 3 : 1;
    for (;;) {
      const Message request = receive(30);
      if (request.type == "abort") return 1;
      if (request.type.empty()) return 3;
      reply(request);
      if (request.type == "finish") return 0;
    }
  }

 private:
  void reply(const Message& request) {
    Message out{.type = "", .sequence = request.sequence, .fields = {}, .arrays = {}};
    out.fields = {{"busy_seconds", 0.0}};
    std::string phase;
    std::string afterwards;
    if (request.type == "solve_step") {
      const StepRequest step = read_step_request(request);
      InterfaceValues sent;
      put(out, solver_.solve_step(step, received(request), sent));
      out.type = "solved";
      put_values(out, hello_.sends.name, hello_.interfaces, sent);
      const bool now = step.step == 3 && step.iteration == 0;
      if (now) phase = "inside_solve", afterwards = "after_solve";
    } else if (request.type == "accept_step") {
      out.type = "accepted";
      const StepRequest step = read_step_request(request);
      put(out, solver_.accept_step(step, true));
      if (step.step == 3 && misdeed_.kind == "wrong_sizes") phase = "after_solve";
      if (step.step == 2) afterwards = "before_solve";
    } else if (request.type == "write_output") {
      out.type = "written";
      if (request.number("time") > 0.03) phase = "output";
    } else if (request.type == "summarize") {
      out.type = "summary";
      out.fields["summary"] = Json::object();
    } else {
      out.type = request.type == "finish" ? "finished" : "rejected";
    }
    say(out, phase);
    if (afterwards == misdeed_.phase && misdeed_.kind != "wrong_sizes") {
      sleep_for(0.15);
      say(out, afterwards);
    }
  }

  InterfaceValues received(const Message& request) const {
    if (request.arrays.empty()) return {};
    return read_values(request, hello_.receives.name, hello_.interfaces);
  }

  /// The message, spoilt when this is the phase for it.
  void say(Message message, const std::string& phase) {
    const bool now = phase == misdeed_.phase && !phase.empty();
    if (now) note_strike();
    if (now) spoil(message);
    const EncodedMessage encoded = encode(message);
    std::vector<std::string_view> frames = {encoded.header};
    frames.insert(frames.end(), encoded.payloads.begin(), encoded.payloads.end());
    if (now && misdeed_.kind == "garbage") frames = {"\xFF\x00\x7Fgarbage", "more of it"};
    if (now && misdeed_.kind == "truncated") frames.back().remove_suffix(3);
    if (now && misdeed_.kind == "lost_frame") frames.pop_back();
    socket_.send(frames);
  }

  void spoil(Message& message) const {
    if (misdeed_.kind == "wrong_sequence") message.sequence += 1;
    if (misdeed_.kind == "wrong_type")
      message.type = message.type == "solved" ? "accepted" : "solved";
    if (message.arrays.empty()) return;
    Array& array = message.arrays.front();
    auto& values = std::get<std::vector<double>>(array.values);
    if (misdeed_.kind == "nan") values[0] = std::numeric_limits<double>::quiet_NaN();
    if (misdeed_.kind == "wrong_sizes") {
      const std::size_t row = values.size() / static_cast<std::size_t>(array.shape[0]);
      values.resize(values.size() - row);
      array.shape[0] -= 1;
    }
  }

  /// Type "" after so many seconds without a message.
  Message receive(double seconds) {
    const Stopwatch waited;
    while (waited.seconds() < seconds) {
      const auto frames = socket_.receive(100);
      if (!frames) continue;
      Message message = decode(std::span(*frames));
      if (message.type != "alive") return message;
    }
    return {};
  }

  Socket socket_;
  Hello hello_;
  Misdeed misdeed_;
  double patience_;
  FakeSolver solver_;
};

}  // namespace gabion::test
