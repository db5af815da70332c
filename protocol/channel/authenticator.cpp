// SPDX-License-Identifier: BSD-3-Clause
#include "protocol/channel/authenticator.hpp"

#include <fmt/format.h>

#include <array>
#include <chrono>
#include <vector>

#include "common/base/interrupt.hpp"
#include "protocol/channel/keys.hpp"

namespace gabion {
namespace {

constexpr std::chrono::milliseconds question_period(50);

std::string z85(const zmq::message_t& key) {
  std::array<char, key_bytes * 5 / 4 + 1> text{};
  if (key.size() != key_bytes) return "";
  zmq_z85_encode(text.data(), key.data<std::uint8_t>(), key_bytes);
  return text.data();
}

}  // namespace

Authenticator::Authenticator(zmq::context_t& context, std::set<std::string> clients)
    : clients_(std::move(clients)), socket_(context, zmq::socket_type::rep) {
  socket_.set(zmq::sockopt::linger, 0);
  socket_.bind("inproc://zeromq.zap.01");
  thread_ = interrupt::quiet_thread([this] { run(); });
}

Authenticator::~Authenticator() {
  stopping_ = true;
  thread_.join();
}

void Authenticator::run() {
  while (!stopping_) {
    try {
      zmq::pollitem_t item{socket_.handle(), 0, ZMQ_POLLIN, 0};
      if (zmq::poll(&item, 1, question_period) > 0) answer_one();
    } catch (const zmq::error_t&) {
      // The process that asked gets no answer, so it is not admitted.
    }
  }
}

/// Request: version, id, domain, address, routing id, mechanism, credentials; reply: version, id,
/// status, text, user, metadata.
void Authenticator::answer_one() {
  std::vector<zmq::message_t> request(1);
  if (!socket_.recv(request.back(), zmq::recv_flags::dontwait)) return;
  while (request.back().more()) {
    request.emplace_back();
    if (!socket_.recv(request.back(), zmq::recv_flags::dontwait)) return;
  }
  const bool known = request.size() == 7 && request[5].to_string() == "CURVE";
  const std::string key = known ? z85(request[6]) : "";
  const bool allowed = clients_.contains(key);
  if (!allowed) {
    strangers_.refuse(key,
                      fmt::format("refused a connection from {}: its public key {} is not in "
                                  "protocol/security/clients_file",
                                  request.size() > 3 ? request[3].to_string() : "nowhere", key));
  }
  const std::string id = request.size() > 1 ? request[1].to_string() : "";
  const std::array<std::string, 6> reply = {
      "1.0", id, allowed ? "200" : "400", allowed ? "OK" : "unknown key", allowed ? key : "", ""};
  for (std::size_t i = 0; i < reply.size(); ++i) {
    const auto flags = i + 1 < reply.size() ? zmq::send_flags::sndmore : zmq::send_flags::none;
    socket_.send(zmq::buffer(reply[i]), flags | zmq::send_flags::dontwait);
  }
}

}  // namespace gabion
