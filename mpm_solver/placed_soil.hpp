// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/run/start.hpp"
#include "mpm_solver/mpm_solver.hpp"

namespace gabion::mpm {

/// A soil whose interfaces may begin displaced: it is set up with them there, at X + u0. Contact,
/// its checks at the start and initial stress then see them there, and they receive u - u0. Where
/// nothing begins displaced, results are those of MpmSolver to the bit.
/// @note Every function is collective over the ranks of `comm`.
template <int dim>
class PlacedSoil final : public Solver, public TakesStart, public TakesFacets {
 public:
  /// The soil of MpmSolver, with the interfaces at X. Where the soil cannot begin with them there,
  /// as soil inside the structure, it may begin with them elsewhere: set_start can follow, or a
  /// state is loaded. Any other function but those of the handshake throws that ConfigError.
  PlacedSoil(MPI_Comm comm, MpmSettings<dim> settings, std::string output_folder);

  /// The interfaces at X.
  std::vector<InterfaceMesh> interfaces() const override { return meshes_; }
  std::vector<std::string> probe_names() const override { return soil_->probe_names(); }
  /// Set the soil up again where the interfaces are elsewhere than before.
  /// @throws ConfigError  as the constructor; says how far they are from X
  void set_start(const InterfaceValues& displacements) override;
  bool takes_facets() const override { return soil_->takes_facets(); }
  void set_facets(const InterfaceFacets& facets) override { begun().set_facets(facets); }
  /// Solve a step; interfaces without received values stay where they began.
  StepReport solve_step(const StepRequest& request, const InterfaceValues& received,
                        InterfaceValues& sent) override;
  AcceptReport accept_step(const StepRequest& request, bool solved) override {
    return soil_->accept_step(request, solved);
  }
  void reject_step() override { soil_->reject_step(); }
  void write_output(double time) override { begun().write_output(time); }
  std::vector<double> probes() const override { return soil_->probes(); }
  Json summary() const override { return begun().summary(); }
  bool keeps_state() const override { return true; }
  State save_state() override;
  void load_state(const State& state) override;
  bool joins_states() const override { return true; }
  void join_states(const State& first, std::span<const State> own) override;

  const MpmSolver<dim>& soil() const { return *soil_; }

 private:
  void begin_at_reference();
  MpmSolver<dim>& begun() const;
  void place(InterfaceValues start);
  void place_as(const State& state);
  std::string text_of(const InterfaceValues& start) const;

  MPI_Comm comm_;
  std::optional<MpmSettings<dim>> settings_;  // at X; empty after the first step began
  std::string output_folder_;
  std::vector<InterfaceMesh> meshes_;
  InterfaceValues start_;  // of all interfaces [m]; empty: at X
  std::unique_ptr<MpmSolver<dim>> soil_;
  std::string problem_;  // why it cannot begin where the interfaces are; empty: it can
};

}  // namespace gabion::mpm
