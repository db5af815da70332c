// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/checks/varying_values.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "common/base/log.hpp"
#include "common/base/require.hpp"
#include "common/mechanics/ranks/sum.hpp"
#include "common/run/csv_writer.hpp"

namespace gabion::mpm {

template <int dim>
void write_varying(const std::string& path, const MpmSettings<dim>& settings) {
  std::set<std::string> names;
  for (const Body<dim>& body : settings.bodies) {
    names.insert(body.varying.begin(), body.varying.end());
  }
  require<ConfigError>(!names.empty(),
                       "{}: found no material with constants that vary in space, allowed: a scene "
                       "where a body has some",
                       settings.bodies_where);
  std::vector<std::string> columns = {"body", "x", "y"};
  if (dim == 3) columns.emplace_back("z");
  columns.insert(columns.end(), names.begin(), names.end());
  CsvWriter csv(path, columns);
  for (std::size_t b = 0; b < settings.bodies.size(); ++b) {
    if (!settings.varying[b]) continue;
    const auto& own = settings.bodies[b].varying;
    MaterialPoints<dim> points;
    lay_points<dim>(settings.layouts[b], 1, {}, points);
    for (const Vector<dim>& x : points.x) {
      std::vector<CsvValue> row = {static_cast<std::int64_t>(b)};
      row.insert(row.end(), x.data(), x.data() + dim);
      const VaryingParameters values = settings.varying[b]->at(x);
      for (const std::string& name : names) {
        const auto column = std::ranges::find(own, name) - own.begin();
        row.emplace_back(column < std::ssize(own) ? values[column]
                                                  : std::numeric_limits<double>::quiet_NaN());
      }
      csv.row(row);
    }
  }
}

template <int dim>
void log_varying(const MpmSettings<dim>& settings, const MaterialPoints<dim>& points,
                 MPI_Comm comm) {
  for (std::size_t b = 0; b < settings.varying.size(); ++b) {
    const auto& names = settings.bodies[b].varying;
    for (std::size_t k = 0; k < names.size(); ++k) {
      double least = std::numeric_limits<double>::infinity(), largest = -least;
      double sums[] = {0, 0};  // of values, of points
      for (std::int32_t p = points.body_starts[b]; p < points.body_starts[b + 1]; ++p) {
        const double value = points.parameters[p][static_cast<Eigen::Index>(k)];
        least = std::min(least, value);
        largest = std::max(largest, value);
        sums[0] += value;
        sums[1] += 1;
      }
      sum_over_ranks(comm, std::span<double>(sums));
      log::info("\"{}\": {} varies from {:.4g} to {:.4g}, mean {:.4g}", settings.bodies[b].name,
                names[k], -max_over_ranks(comm, -least), max_over_ranks(comm, largest),
                sums[0] / sums[1]);
    }
  }
}

template void write_varying<2>(const std::string&, const MpmSettings<2>&);
template void write_varying<3>(const std::string&, const MpmSettings<3>&);
template void log_varying<2>(const MpmSettings<2>&, const MaterialPoints<2>&, MPI_Comm);
template void log_varying<3>(const MpmSettings<3>&, const MaterialPoints<3>&, MPI_Comm);

}  // namespace gabion::mpm
