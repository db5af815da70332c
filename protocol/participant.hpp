// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "common/base/timer.hpp"
#include "common/run/facets.hpp"
#include "common/run/solver.hpp"
#include "protocol/participant/connection.hpp"
#include "protocol/participant/own_facets.hpp"
#include "protocol/participant/state_machine.hpp"
#include "protocol/participant/usage_error.hpp"

namespace gabion {

/// One coupler, driven by the time loop of a foreign code; serve() is the face for codes that are
/// driven.
///
///     Participant participant(settings);
///     participant.set_interface("wall", coordinates, 2, facets);
///     participant.initialize();
///     while (participant.is_coupling_ongoing()) {
///       if (participant.requires_writing_checkpoint()) save();
///       const double dt = std::min(own_dt, participant.get_max_time_step_size());
///       solve(dt, participant.read_data("wall"));
///       participant.write_data("wall", displacement);
///       participant.advance(dt);
///       if (participant.requires_reading_checkpoint()) restore();
///     }
///     participant.finalize();
///
/// All calls throw UsageError, ProtocolError or Interrupted; what is wrong on the wire is final.
class Participant : private RequestHandler {
 public:
  explicit Participant(ParticipantSettings settings);
  ~Participant() override;  ///< before the end of the coupling: tells the coupler
  Participant(const Participant&) = delete;
  Participant& operator=(const Participant&) = delete;
  Participant(Participant&&) = delete;
  Participant& operator=(Participant&&) = delete;

  /// Set a coupled surface in its reference configuration. Call it before initialize().
  /// @param coordinates         [m], num_vertices x dim, row-major
  /// @param vertices_per_facet  2, 3, 4; 0 for bare points
  /// @param facets              vertex numbers from 0, num_facets x vertices_per_facet; normals out
  ///                            of the structure: in 2D to the right when going along the segment
  void set_interface(const std::string& name, std::span<const double> coordinates,
                     int vertices_per_facet = 0, std::span<const std::int64_t> facets = {});
  /// Set the kind of force that a soil sends on this interface; by default the force at the end of
  /// the step. Call it before initialize() and after set_interface().
  void set_force_kind(const std::string& interface, ForceKind kind);
  /// Set the displacements of an interface in the initial state of a structure that begins
  /// displaced, such as in equilibrium with its weight. Call it before initialize() and after
  /// set_interface().
  /// @param values  [m], num_vertices x dim
  void set_start_displacement(const std::string& interface, std::span<const double> values);
  /// Set the function `take(displacements)` of a soil, which gets the displacements [m] of all
  /// interfaces where the structures begin. It is called in initialize(), only where one of them is
  /// displaced, not in a restart; it calls write_probes() where they change. Displacements of
  /// read_data() remain total, from the reference. `take` throws where the soil cannot begin so,
  /// which ends the run. Call it before initialize().
  void on_set_start(std::function<void(const InterfaceValues&)> take);
  /// Declare that facets of an interface of a structure may leave it, or come, where cells fail.
  /// Its vertices are all that a facet may ever have. Call it before initialize() and after
  /// set_interface(), which gives the facets of the beginning.
  void set_facets_may_change(const std::string& interface);
  /// Set all facets that an interface has from the step on that was just accepted. Call it when
  /// is_time_window_complete(), before the next is_coupling_ongoing(), where they change; and
  /// within `load` of set_state(), for each interface that may change.
  /// @param facets  num_facets x vertices_per_facet, as in set_interface(); may be empty
  void write_facets(const std::string& interface, std::span<const std::int64_t> facets);
  /// Set the function `take(facets)` of a soil, which lets these interfaces have other facets from
  /// now on, of the same vertices; a saved state has them. It is called between two steps. `take`
  /// throws where the soil cannot go on so, which ends the run. Call it before initialize().
  void on_set_facets(std::function<void(const InterfaceFacets&)> take);
  /// Set the numbers that the run shall record. Call it before initialize().
  /// @param values  in the initial state, as many as names
  void set_probes(std::vector<std::string> names, std::span<const double> values);
  /// Set the values of the probes at the end of the step; call it before advance().
  void write_probes(std::span<const double> values);
  /// Set the function `write(time)` [s], which is called when the coupler wants the accepted state
  /// on disk; this is then the code's current state. Without it the code writes when it likes, such
  /// as after is_time_window_complete(). Call it before initialize().
  void set_output(std::function<void(double)> write);
  /// Set the functions with which a run with this code can be restarted (optional). Call it before
  /// initialize().
  /// @param save  gives all of the accepted state, which then is the code's current state, that
  ///              later steps depend on, in a form of the code's own
  /// @param load  continues from what `save` gave, perhaps in an earlier run; calls write_probes().
  ///              Each later step then gives the bits that it would have given there. Called in
  ///              initialize() already, or between two steps. It calls write_facets() of each
  ///              interface whose facets may change.
  void set_state(std::function<std::vector<std::byte>()> save,
                 std::function<void(std::span<const std::byte>)> load);
  /// Set the entry of this participant in summary.json.
  void set_summary(Json summary);

  /// Connect, introduce, and wait for the first step.
  void initialize();
  /// Settings of the run as the coupler gave them: end time, dt, folders.
  const Json& run_settings() const;

  /// Whether there is a step to solve. Tells the coupler that the last one is done with, and waits
  /// for the next.
  bool is_coupling_ongoing();
  /// Whether the last advance() ended with an accepted step.
  bool is_time_window_complete() const;
  /// [s] that are left of the open step; 0 after the end.
  double get_max_time_step_size();
  /// [s] of the accepted state from which the open step starts.
  double get_time();

  /// Whether to save the current, accepted state. To ask is the promise to do so.
  bool requires_writing_checkpoint();
  /// Whether to go back to the state that was saved. To ask is the promise to do so.
  bool requires_reading_checkpoint();

  /// Kind of force that read_data() gives on this interface: that at the end of the step, or the
  /// mean force, which is to act as a constant load over the step. It does not change during a run.
  ForceKind force_kind(const std::string& interface);
  /// The received values at the end of the step, num_vertices x dim: force [N] or displacement [m].
  std::vector<double> read_data(const std::string& interface);
  /// Set the values to send at the end of the step, num_vertices x dim: displacement [m] or force
  /// [N].
  void write_data(const std::string& interface, std::span<const double> values);

  /// Note that the code has advanced by `dt` [s], at most get_max_time_step_size(). At the end of
  /// the step: send what was written, and wait for the verdict.
  void advance(double dt, const StepReport& report = {});
  /// Call it instead of advance() when the open step has no solution. The coupler will try a
  /// smaller one; go back to the saved state.
  void fail_step(const std::string& reason);

  /// Close; before the end of the coupling, tell the coupler that this participant gives up.
  void finalize();

  /// Number of values of an interface, num_vertices x dim.
  std::size_t num_values(const std::string& interface) const;
  int vertices_per_facet(const std::string& interface) const {
    return mesh(interface).vertices_per_facet;
  }

 private:
  // The functions below answer the coupler. An answer is pending while it waits for the code, which
  // may have to go back first.
  Answer set_force_kinds(const ForceKinds& kinds) override;
  Answer set_start(const InterfaceValues& displacements) override;
  Answer set_facets(const InterfaceFacets& facets) override;
  Answer solve_step(const StepRequest& step, InterfaceValues received) override;
  Answer accept_step(const StepRequest& step, bool solved) override;
  Answer reject_step() override;
  Answer write_output(double time) override;
  Answer save_state(const std::string& file) override;
  Answer load_state(const Message& request) override;
  Answer summarize() override;
  bool is_inside_step() const override { return awaits_verdict_; }

  void settle();
  void await_step();
  void await_verdict();
  void do_next_request();
  void reply(Message message);
  void answer_step(Message message);

  void before_initialize(const char* call) const;
  void after_initialize() const;
  const StepRequest& open_step(const char* call);
  const StepRequest& checked_step(const char* call);
  const InterfaceMesh& mesh(const std::string& name) const;
  void warn_of_step_means();

  ParticipantSettings settings_;
  std::vector<InterfaceMesh> meshes_;
  std::vector<std::string> probe_names_;
  std::vector<double> probes_;           // probes in the code's current state
  std::vector<double> accepted_probes_;  // probes in the accepted state
  InterfaceValues start_;                // displacements of the start where any is not zero [m]
  std::function<void(const InterfaceValues&)> take_start_;  // empty: does not take one
  OwnFacets facets_;
  std::function<void(const InterfaceFacets&)> take_facets_;  // empty: does not take others
  std::function<void(double)> output_;
  std::function<std::vector<std::byte>()> save_;  // empty: does not keep its state
  std::function<void(std::span<const std::byte>)> load_;
  Json summary_ = Json::object();
  std::unique_ptr<Connection> connection_;  // after initialize()

  std::unique_ptr<StateMachine> machine_;  // after initialize()
  std::optional<StepRequest> request_;     // the open solve_step
  bool awaits_verdict_ = false;            // it was answered, neither accepted nor rejected
  std::optional<Message> pending_;         // answer that waits until the code has done its part
  ForceKinds force_kinds_;                 // kinds of the received forces
  bool asked_force_kind_ = false;
  InterfaceValues received_;
  InterfaceValues written_;
  double remaining_ = 0;                         // [s] of the open step
  Stopwatch busy_;                               // since the current request came
  bool must_write_ = false, must_read_ = false;  // checkpoints that were not asked for yet
  bool window_complete_ = false;
};

}  // namespace gabion
