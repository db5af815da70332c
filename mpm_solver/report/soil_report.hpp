// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "mpm_solver/report/contact_output.hpp"
#include "mpm_solver/report/memory.hpp"
#include "mpm_solver/report/mpm_output.hpp"
#include "mpm_solver/step/soil_step.hpp"

namespace gabion::mpm {

/// The soil's output: log, probes, frames, summary. Refers to the model. Functions are collective.
template <int dim>
class SoilReport {
 public:
  /// @param output_folder  folder of the frames; empty: none are written
  SoilReport(const SoilModel<dim>& model, const std::string& output_folder);

  /// Log locking, grid and basis of a run that begins.
  void log_start(const SoilState<dim>& state, const PointWeights<dim>& weights) const;

  /// Columns of probes.csv.
  std::vector<std::string> probe_names() const;
  std::vector<double> probes(const SoilState<dim>& state) const;

  /// A step was accepted.
  void look_at_memory(const SoilState<dim>& state, const SoilStep<dim>& step) {
    memory_.look(state, step);
  }
  void write_frame(double time, const SoilState<dim>& state);
  Json summary(const SoilState<dim>& state, const SoilStep<dim>& step,
               const PhaseTimes& times) const;

 private:
  Json small_cuts(const SoilStep<dim>& step) const;
  Json ranks(const SoilState<dim>& state, const SoilStep<dim>& step) const;

  const SoilModel<dim>& model_;
  MpmOutput<dim> output_;
  ContactOutput<dim> contact_output_;
  Memory<dim> memory_;
};

}  // namespace gabion::mpm
