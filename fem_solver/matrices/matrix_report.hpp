// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "common/base/json.hpp"
#include "common/mechanics/output/xdmf_series.hpp"
#include "fem_solver/matrices/coordinates.hpp"
#include "fem_solver/matrices/linear_step.hpp"
#include "fem_solver/matrices/matrix_structure.hpp"

namespace gabion::fem {

/// Output of a structure of matrices: probes, frames, summary. Columns of probes.csv: displacement
/// of the probes' nodes, kinetic_energy, elastic_energy, external_work, and damping_work where
/// there is damping [J]. Frames: displacement, velocity and external_force of the nodes that have
/// coordinates.
template <int dim>
class MatrixReport {
 public:
  /// Refers to the structure and its coordinates.
  /// @param folder  of the frames; empty: this rank writes none
  /// @throws ConfigError  no node at a probe
  MatrixReport(const MatrixSettings<dim>& settings, const MatrixStructure<dim>& structure,
               const Coordinates& coordinates, std::string folder);

  const std::vector<std::string>& probe_names() const { return names_; }
  std::vector<double> probes(const LinearState& state, const LinearStep& step) const;

  /// @param f  interface forces and loads on the nodes, num_nodes x dim [N]
  void write_frame(const LinearState& state, const std::vector<double>& f);
  Json summary(const LinearStep& step) const;

 private:
  std::vector<double> on_nodes(const Eigen::VectorXd& q) const;
  OutputFrame frame(const std::vector<double>& x) const;

  const MatrixStructure<dim>& structure_;
  const Coordinates& coordinates_;
  bool dynamic_;
  std::string folder_;
  std::vector<std::string> names_;
  std::vector<std::int32_t> probe_nodes_;
  CellType cell_type_;
  std::vector<std::int32_t> cells_;   // of the frames
  std::optional<XdmfSeries> series_;  // from the first frame on
};

}  // namespace gabion::fem
