// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/run/facets.hpp"
#include "protocol/participant/step_order.hpp"
#include "protocol/wire/message.hpp"

namespace gabion {

/// Actions of one kind of participant at each request. An empty answer follows later.
class RequestHandler {
 public:
  using Answer = std::optional<Message>;
  virtual ~RequestHandler() = default;

  virtual Answer set_force_kinds(const ForceKinds& kinds) = 0;
  /// @param displacements  of the interfaces in the initial state
  virtual Answer set_start(const InterfaceValues& displacements);
  virtual Answer set_facets(const InterfaceFacets& facets);
  virtual Answer solve_step(const StepRequest& step, InterfaceValues received) = 0;
  virtual Answer accept_step(const StepRequest& step, bool solved) = 0;
  virtual Answer reject_step() = 0;
  virtual Answer write_output(double time) = 0;
  /// @param file  where the state may be written instead; empty: nowhere
  virtual Answer save_state(const std::string& file) = 0;
  virtual Answer load_state(const Message& request) = 0;
  virtual Answer summarize() = 0;
  /// Whether the code's current state may be another one than the accepted one.
  virtual bool is_inside_step() const { return false; }
};

/// The state machine of a participant (README.md, section 5): which request is allowed when, which
/// fields it has, and that steps follow one another. It serves all kinds of participants.
class StateMachine {
 public:
  /// @param handler     carries out the requests; outlives this
  /// @param receives    name of the quantity, as "force"
  /// @param interfaces  on which it is received
  /// @param self        in messages: who does not know an unknown request
  StateMachine(RequestHandler& handler, std::string receives, std::vector<InterfaceMesh> interfaces,
               std::string self);

  /// Have the request carried out.
  /// @returns  the answer; empty: it follows later
  /// @throws ProtocolError  not known, not allowed now, or not complete
  std::optional<Message> handle(Message request);
  /// Note an answer "solved" that followed later.
  void solved(const StepRequest& step) { order_.solved(step); }
  /// Whether "finish" was asked: there is no further request.
  bool is_finished() const { return finished_; }
  /// @throws ProtocolError  a request of this type is unknown here
  [[noreturn]] void refuse(const std::string& type) const;

 private:
  using Answer = RequestHandler::Answer;
  struct Rule {
    const char* type;
    bool inside_step;  // allowed while a solution waits for its verdict
    Answer (StateMachine::*handle)(Message request);
  };
  static const std::vector<Rule>& rules();

  Answer set_force_kinds(Message request);
  Answer set_start(Message request);
  Answer set_facets(Message request);
  Answer solve(Message request);
  Answer accept(Message request);
  Answer reject(Message request);
  Answer write(Message request);
  Answer save(Message request);
  Answer load(Message request);
  Answer summarize(Message request);
  Answer finish(Message request);

  RequestHandler& handler_;
  std::string receives_;
  std::vector<InterfaceMesh> interfaces_;
  std::string self_;
  StepOrder order_;
  double proposed_dt_ = 0;  // [s] by the last answer to accept_step
  bool finished_ = false;
};

}  // namespace gabion
