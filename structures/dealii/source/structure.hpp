// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <common/run/start.hpp>
#include <protocol/serve.hpp>

#include <memory>
#include <optional>

#include "frames.hpp"
#include "newmark_step.hpp"
#include "wet_surface.hpp"

namespace dealii_structure {

/// The solid behind the coupler: it asks, these functions answer.
template <int dim>
class Structure final : public gabion::Solver, public gabion::DisplacedAtStart {
 public:
  /// @throws gabion::ConfigError, gabion::ConvergenceError
  explicit Structure(const Settings& settings);

  /// Frames go to this folder; without it nothing is written.
  void write_to(const std::string& folder) { frames_.emplace(folder); }

  std::vector<gabion::InterfaceMesh> interfaces() const override;
  bool takes_force_kinds() const override { return true; }
  void set_force_kinds(const gabion::ForceKinds& kinds) override;
  gabion::InterfaceValues start_displacements() const override;
  gabion::StepReport solve_step(const gabion::StepRequest& request,
                                const gabion::InterfaceValues& received,
                                gabion::InterfaceValues& sent) override;
  gabion::AcceptReport accept_step(const gabion::StepRequest& request, bool solved) override;
  void reject_step() override {}  // the accepted state was not changed
  void write_output(double time) override;
  std::vector<std::string> probe_names() const override;
  std::vector<double> probes() const override;
  bool keeps_state() const override { return true; }
  gabion::State save_state() override;
  void load_state(const gabion::State& state) override;
  gabion::Json summary() const override;

 private:
  Settings settings_;
  ElasticSolid<dim> solid_;
  NewmarkStep<dim> stepper_;
  std::vector<WetSurface<dim>> surfaces_;
  std::vector<typename ElasticSolid<dim>::Interpolation> probed_;
  gabion::ForceKinds force_kinds_;
  SolidState accepted_, trial_;
  std::optional<Frames<dim>> frames_;
  long solves_ = 0, newton_iterations_ = 0;
};

}  // namespace dealii_structure
