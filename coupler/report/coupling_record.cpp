// SPDX-License-Identifier: BSD-3-Clause
#include "coupler/report/coupling_record.hpp"

namespace gabion {

namespace {

using Columns = std::vector<std::string>;
using Cells = std::vector<CsvValue>;

constexpr int iterations_schema = 2;  // docs/results.md; a change of meaning or order adds 1

void append(Columns& columns, const Columns& more) {
  columns.insert(columns.end(), more.begin(), more.end());
}

void append_force(Cells& cells, const Eigen::Vector3d& force, int dim) {
  for (int i = 0; i < dim; ++i) cells.emplace_back(force(i));
}

/// Empty where a residual does not exist.
CsvValue optional_cell(const std::optional<double>& value) {
  return value ? CsvValue(*value) : CsvValue(std::string());
}

CsvValue cell(int value) {
  return std::int64_t{value};
}

}  // namespace

std::string name(Skipped skipped) {
  if (skipped == Skipped::nothing) return "none";
  return skipped == Skipped::acceleration ? "acceleration" : "structure";
}

Columns CouplingRecord::force_columns(const std::string& prefix) const {
  Columns columns = {prefix + "x", prefix + "y"};
  if (dim_ == 3) columns.push_back(prefix + "z");
  return columns;
}

/// Force and moment of each interface.
Columns CouplingRecord::interface_columns() const {
  Columns columns;
  for (const std::string& interface : interfaces_) {
    append(columns, force_columns(interface + ".f"));
    append(columns, dim_ == 2 ? Columns{interface + ".mz"} : force_columns(interface + ".m"));
  }
  return columns;
}

void CouplingRecord::start(const Columns& probe_names) {
  Columns columns = {"schema",
                     "step",
                     "iteration",
                     "time",
                     "dt",
                     "status",
                     "displacement_residual",
                     "displacement_limit",
                     "force_residual",
                     "force_limit",
                     "omega",
                     "columns",
                     "dropped_by_filter",
                     "dropped_by_limit",
                     "dropped_by_contact",
                     "fell_back"};
  append(columns, force_columns("soil_f"));
  append(columns, force_columns("structure_f"));
  append(columns, {"mismatch_force", "mismatch_moment", "soil_newton", "structure_newton",
                   "soil_seconds", "structure_seconds", "wall_seconds"});
  files_.open_table("iterations.csv", columns);
  Columns probes = {"time"};
  append(probes, probe_names);
  files_.open_table("probes.csv", probes);
}

void CouplingRecord::iteration(const IterationRow& row) {
  Cells cells = {cell(iterations_schema),
                 row.request.step,
                 cell(row.request.iteration),
                 row.request.time,
                 row.request.dt,
                 name(row.state.verdict),
                 row.state.displacement_residual,
                 optional_cell(row.state.displacement_limit),
                 optional_cell(row.state.force_residual),
                 optional_cell(row.state.force_limit),
                 row.acceleration.omega,
                 cell(row.acceleration.columns),
                 cell(row.acceleration.dropped_by_filter),
                 cell(row.acceleration.dropped_by_limit),
                 cell(row.acceleration.dropped_by_contact),
                 cell(row.acceleration.fell_back ? 1 : 0)};
  append_force(cells, row.soil.force, dim_);
  append_force(cells, row.structure.force, dim_);
  cells.emplace_back((row.soil.force - row.structure.force).norm());
  cells.emplace_back((row.soil.moment - row.structure.moment).norm());
  cells.push_back(cell(row.soil_newton));
  cells.push_back(cell(row.structure_newton));
  cells.emplace_back(row.soil_seconds);
  cells.emplace_back(row.structure_seconds);
  cells.emplace_back(row.wall_seconds);
  files_.row("iterations.csv", cells);
}

void CouplingRecord::start_steps(const Json& details) {
  if (!details_.started()) details_.start(details);
  Columns columns = {
      "step",          "time", "dt", "iterations", "status", "skipped", "displacement_residual",
      "force_residual"};
  append(columns, force_columns("f"));
  append(columns,
         {"soil_work", "structure_work", "work_sum", "soil_newton", "structure_newton", "cuts"});
  append(columns, interface_columns());
  append(columns, details_.names());
  append(columns, {"acceleration_seconds", "wall_seconds"});
  files_.open_table("steps.csv", columns);
}

void CouplingRecord::step(const StepRow& row) {
  if (!files_.has_table("steps.csv")) start_steps(row.details);
  Cells cells = {row.last.request.step,
                 row.time,
                 row.last.request.dt,
                 cell(row.iterations),
                 row.status,
                 name(row.skipped),
                 row.last.state.displacement_residual,
                 optional_cell(row.last.state.force_residual)};
  append_force(cells, row.last.structure.force, dim_);
  cells.emplace_back(row.soil_work);
  cells.emplace_back(row.structure_work);
  cells.emplace_back(row.soil_work + row.structure_work);
  cells.push_back(cell(row.soil_newton));
  cells.push_back(cell(row.structure_newton));
  cells.push_back(cell(row.cuts));
  for (const Resultant& of : row.interfaces) {
    append_force(cells, of.force, dim_);
    for (int i = dim_ == 2 ? 2 : 0; i < 3; ++i) cells.emplace_back(of.moment(i));
  }
  details_.append(row.details, cells);
  cells.emplace_back(row.acceleration_seconds);
  cells.emplace_back(row.wall_seconds);
  files_.row("steps.csv", cells);
}

void CouplingRecord::probes(double time, const std::vector<double>& values) {
  Cells cells = {time};
  cells.insert(cells.end(), values.begin(), values.end());
  files_.row("probes.csv", cells);
}

}  // namespace gabion
