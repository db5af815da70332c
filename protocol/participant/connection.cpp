// SPDX-License-Identifier: BSD-3-Clause
#include "protocol/participant/connection.hpp"

#include <fmt/format.h>

#include <random>
#include <span>
#include <utility>

#include "common/base/interrupt.hpp"
#include "common/base/log.hpp"
#include "common/base/require.hpp"
#include "common/run/facets.hpp"
#include "common/run/start.hpp"
#include "gabion_version.hpp"
#include "protocol/channel/own_sleep.hpp"
#include "protocol/wire/codec.hpp"
#include "protocol/wire/exchange.hpp"

namespace gabion {
namespace {

constexpr int last_words_milliseconds = 300;  // for what a coupler said before it went

std::string random_text() {
  std::random_device device;
  return fmt::format("{:08x}{:08x}", device(), device());
}

}  // namespace

Connection::Connection(const ParticipantSettings& settings)
    : settings_(settings),
      session_(random_text()),
      keys_(read_client_keys(settings.key_file, settings.coupler_key_file)),
      context_(make_socket_context()),
      socket_(Socket::connect_dealer(context_, settings.endpoint, settings.name + "#" + session_,
                                     500, keys_)),
      heartbeat_(std::make_unique<Heartbeat>(
          context_,
          HeartbeatSettings{settings.endpoint, settings.name + "#" + session_ + "#alive",
                            settings.name, session_, settings.exit_when_coupler_is_lost, keys_})) {}

Connection::~Connection() {
  if (!welcomed() || !socket_) return;
  try {
    const bool by_exception = std::uncaught_exceptions() > exceptions_;
    abort(std::string("the participant ended before the run was finished") +
          (by_exception ? ", by an exception that its own output may tell" : ""));
  } catch (const std::exception&) {
    // The coupler cannot be told; it notices the silence.
  }
}

bool Connection::send(const Message& message) {
  const EncodedMessage encoded = encode(message);
  std::vector<std::string_view> frames = {encoded.header};
  frames.insert(frames.end(), encoded.payloads.begin(), encoded.payloads.end());
  return socket_->send(frames);
}

void Connection::post(const Message& message) {
  require<ProtocolError>(send(message),
                         "cannot send \"{}\" to the coupler at {}: its queue is full", message.type,
                         settings_.endpoint);
}

void Connection::fail(const std::string& reason) {
  failure_ = reason;
  throw ProtocolError(reason);
}

void Connection::fail_at_start(const std::string& reason) {
  failure_ = reason;
  throw NeverBegun(reason);
}

Hello hello_of(const ParticipantSettings& settings, const Introduction& introduction) {
  Hello hello;
  hello.participant = settings.name;
  hello.program = settings.program;
  hello.program_version = settings.program_version.empty() ? version : settings.program_version;
  hello.scene_hash = settings.scene_hash;
  hello.dimension = settings.dimension;
  hello.receives = settings.receives;
  hello.sends = settings.sends;
  hello.interfaces = introduction.interfaces;
  hello.probe_names = introduction.probe_names;
  hello.probes = introduction.probes;
  hello.keeps_state = introduction.keeps_state;
  hello.takes_force_kinds = introduction.takes_force_kinds;
  hello.start = introduction.start;
  hello.takes_start = introduction.takes_start;
  hello.takes_facets = introduction.takes_facets;
  hello.changing = introduction.changing;
  hello.takes_next_step = true;  // requests are taken from the socket one by one
  return hello;
}

void Connection::handshake(const Solver& solver) {
  handshake({.interfaces = solver.interfaces(),
             .probe_names = solver.probe_names(),
             .probes = solver.probes(),
             .keeps_state = solver.keeps_state(),
             .takes_force_kinds = solver.takes_force_kinds(),
             .start = start_displacements(solver),
             .takes_start = takes_start(solver),
             .takes_facets = takes_facets(solver),
             .changing = changing_interfaces(solver)});
}

void Connection::handshake(const Introduction& introduction) {
  require<ProtocolError>(!welcomed(), "the handshake is done already");
  Hello hello = hello_of(settings_, introduction);
  hello.session = session_;
  hello.process = this_process();
  // If it cannot be sent, the coupler has closed the connection: the wait for an answer tells why.
  send(to_message(hello));
  const Message answer = await_answer_to_hello();
  if (answer.type == "refused") {
    fail_at_start(fmt::format("the coupler at {} refused participant \"{}\": {}",
                              settings_.endpoint, settings_.name, answer.text("reason")));
  }
  if (answer.type == "abort") fail_at_start("the coupler ended the run: " + answer.text("reason"));
  if (answer.type != "welcome")
    fail("expected \"welcome\", the coupler sent \"" + answer.type + "\"");
  const Welcome welcome = read_welcome(answer);
  if (major_version(welcome.protocol) != major_version(protocol_version)) {
    fail(mismatch_text({{"protocol version", welcome.protocol, protocol_version}}));
  }
  run_ = welcome.run;
  deadlines_ = welcome.deadlines;
  coupler_ = std::make_shared<PeerWatch>(fmt::format("the coupler (pid {})", welcome.process.pid),
                                         welcome.process);
  coupler_->sign_of_life("coupling");
  heartbeat_->watch(coupler_, deadlines_.heartbeat, deadlines_.silence);
  log::debug("connected to the coupler at {}", settings_.endpoint);
}

Message Connection::await_answer_to_hello() {
  std::string hint = "is it running there?";
  const Stopwatch waited;
  while (waited.seconds() <= settings_.connect_deadline) {
    // A launcher that saw another process fail sends the signal before the coupler can explain.
    const bool interrupted = interrupt::requested() != 0;
    const int patience = interrupted ? last_words_milliseconds : slice_milliseconds;
    if (const auto frames = socket_->receive(patience)) {
      Message answer = decode(std::span(*frames));
      if (answer.type != "alive") return answer;  // signs of life may come at any time
    }
    if (interrupted) interrupt::check();
    if (const auto refusal = socket_->refusal()) {
      hint = refusal->reason;
      if (refusal->is_final) {
        fail(fmt::format("the coupler at {} refused participant \"{}\" after {:.1f} s: {}",
                         settings_.endpoint, settings_.name, waited.seconds(), hint));
      }
    }
  }
  fail(
      fmt::format("participant \"{}\": no answer from a coupler at {} within {} s (option "
                  "--connect-deadline); {}",
                  settings_.name, settings_.endpoint, settings_.connect_deadline, hint));
}

Message Connection::next_request(Frames* frames) {
  require<ProtocolError>(welcomed() && socket_, "next_request before the handshake or after close");
  require<ProtocolError>(failure_.empty(), "the coupling has failed before: " + failure_);
  heartbeat_->set_phase("waiting", false);
  const Stopwatch waited;
  Attention::Seconds look = attention_.before(last_request_);
  std::optional<Request> request;
  while (!request) {
    // Silence is judged before the queue is read: a message that has arrived counts.
    const bool was_silent = coupler_->silence(deadlines_.silence).has_value();
    request = receive_request(slice_milliseconds, std::exchange(look, {}));
    if (!request) request = look_after_coupler(was_silent);
    if (!request && waited.seconds() > deadlines_.idle) {
      fail(fmt::format("{} is alive but has asked nothing for {:.1f} s (limit {} s, {}); {}",
                       coupler_->label(), waited.seconds(), deadlines_.idle,
                       deadline_option("idle_deadline"), coupler_->last_words()));
    }
  }
  attention_.note(last_request_, Attention::Seconds(waited.seconds()));
  last_request_ = request->message.type;
  if (frames) *frames = std::move(request->frames);
  return std::move(request->message);
}

/// Signs of life are noted and left out.
std::optional<Connection::Request> Connection::receive_request(int milliseconds,
                                                               Attention::Seconds look) {
  auto frames = socket_->receive(milliseconds, look);
  if (!frames) return std::nullopt;
  Message message;
  try {
    message = decode(std::span(*frames));
    if (message.type == "abort") {
      failure_ = "the coupler ended the run: " + message.text("reason");
    }
  } catch (const ProtocolError& problem) {
    throw ProtocolError(fmt::format("{} sent a message that is not understood: {}",
                                    coupler_->label(), problem.what()));
  }
  if (!failure_.empty() && !has_begun_) fail_at_start(failure_);
  if (!failure_.empty()) throw ProtocolError(failure_);
  has_begun_ = has_begun_ || message.type == "solve_step";
  coupler_->sign_of_life();
  if (message.type == "alive") return std::nullopt;
  require<ProtocolError>(message.sequence > last_sequence_,
                         "{} sent \"{}\" with sequence number {} after {}", coupler_->label(),
                         message.type, message.sequence, last_sequence_);
  last_sequence_ = message.sequence;
  // After "finish" nothing is computed: the coupler may end.
  heartbeat_->set_phase(describe(message), message.type != "finish");
  return Request{std::move(message), std::move(*frames)};
}

/// Check the coupler. Throws when it is lost, or a signal came, unless the run is finished: then
/// returns that request.
std::optional<Connection::Request> Connection::look_after_coupler(bool was_silent) {
  const double elapsed = since_health_check_.seconds();
  const int signal = interrupt::requested();
  if (elapsed < health_check_period && signal == 0) return std::nullopt;
  since_health_check_ = Stopwatch();
  if (elapsed > longest_slice) coupler_->forgive();
  const bool ends = signal != 0 && !waits_for_last_checkpoint();
  if (ends || coupler_->death()) {
    // A launcher that saw another process die sends the signal before the coupler can explain.
    if (auto finish = last_words()) return finish;
    if (const auto death = coupler_->death()) fail(*death);
    interrupt::check();
  }
  if (was_silent) {
    if (const auto silence = coupler_->silence(deadlines_.silence)) fail(*silence);
  }
  return std::nullopt;
}

/// Read the last message of a coupler that has ended or is about to: its reason (thrown), or that
/// the run is finished. Other requests are dropped, since nobody awaits their answer.
std::optional<Connection::Request> Connection::last_words() {
  const Stopwatch waited;
  while (1000 * waited.seconds() < last_words_milliseconds) {
    auto request = receive_request(20);
    if (request && request->message.type == "finish") return request;
  }
  return std::nullopt;
}

/// A launcher sends the signal to all programs; the coupler then ends the run after the current
/// step, with a checkpoint.
bool Connection::waits_for_last_checkpoint() {
  if (run_.value("checkpoints", Json()) != true) return false;
  if (!since_signal_) since_signal_.emplace();
  return since_signal_->seconds() < interrupt::patience();
}

void Connection::reply(Message message) {
  require<ProtocolError>(welcomed() && socket_, "reply before the handshake or after close");
  require<ProtocolError>(failure_.empty(), "the coupling has failed before: " + failure_);
  message.sequence = last_sequence_;
  post(message);
}

void Connection::close() {
  // The context closes with the last of its users, and waits for what is not sent yet.
  heartbeat_.reset();
  socket_.reset();
  context_.reset();
}

void Connection::abort(const std::string& reason) {
  if (!failure_.empty() || !socket_) return;
  failure_ = reason;
  Json fields = {{"reason", reason}};
  if (!welcomed()) fields.update({{"participant", settings_.name}, {"program", settings_.program}});
  post({.type = "abort", .sequence = last_sequence_, .fields = std::move(fields), .arrays = {}});
}

}  // namespace gabion
