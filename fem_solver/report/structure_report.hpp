// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "fem_solver/fem_config.hpp"
#include "fem_solver/report/fem_output.hpp"
#include "fem_solver/report/fem_probes.hpp"
#include "fem_solver/report/line_output.hpp"
#include "fem_solver/report/membrane_output.hpp"
#include "fem_solver/report/section_forces.hpp"
#include "fem_solver/step/structure_step.hpp"

namespace gabion::fem {

/// Output of the structure: probes, frames, summary. Refers to the settings and the step. Functions
/// are collective.
template <int dim>
class StructureReport {
 public:
  /// @param output_folder  folder of the frames; empty: none are written
  /// @throws ConfigError  a probe outside the mesh, a section that does not cut it
  StructureReport(const FemSettings<dim>& settings, const StructureStep<dim>& step,
                  const std::string& output_folder);

  /// Columns of probes.csv.
  const std::vector<std::string>& probe_names() const { return names_; }
  std::vector<double> probes(const StructureState& state) const;

  void write_frame(double time, const StructureState& state);
  Json summary() const;

 private:
  const FemSettings<dim>& settings_;
  const StructureStep<dim>& step_;
  FemProbes<dim> probes_;
  std::vector<SectionForces<dim>> sections_;
  MembraneOutput<dim> membranes_;
  std::vector<std::string> names_;    // of the probes, then of membranes and sections
  std::int64_t num_constrained_ = 0;  // unknowns of all ranks
  std::optional<FemOutput<dim>> output_;
  std::optional<LineOutput<dim>> line_output_;
};

}  // namespace gabion::fem
