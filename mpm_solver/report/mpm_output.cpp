// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/report/mpm_output.hpp"

#include <algorithm>
#include <numeric>
#include <utility>

#include "common/mechanics/ranks/gather.hpp"
#include "mpm_solver/points/flat.hpp"

namespace gabion::mpm {

namespace {

using Values = std::span<const double>;

/// Of all points.
struct FrameValues {
  Values u, v, stress, pressure, plastic_strain, J, volume, body;
};

template <int dim>
std::vector<OutputField> frame_fields(const FrameValues& of) {
  return {{"displacement", dim, of.u},
          {"velocity", dim, of.v},
          {"stress", symmetric_size<dim>, of.stress},
          {"pressure", 1, of.pressure},
          {"plastic_strain", 1, of.plastic_strain},
          {"volume_ratio", 1, of.J},
          {"volume", 1, of.volume},
          {"body", 1, of.body}};
}

// Places of the ids in ascending order; empty: they are in order.
std::vector<std::size_t> order_of(const std::vector<std::int64_t>& ids) {
  std::vector<std::size_t> order;
  if (std::is_sorted(ids.begin(), ids.end())) return order;
  order.resize(ids.size());
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(),
            [&](std::size_t a, std::size_t b) { return ids[a] < ids[b]; });
  return order;
}

// As many values a point as there are.
std::vector<double> ordered(const std::vector<std::size_t>& order, std::vector<double> values) {
  if (order.empty()) return values;
  const std::size_t width = values.size() / order.size();
  std::vector<double> result;
  result.reserve(values.size());
  for (const std::size_t p : order) {
    const double* const of_point = values.data() + p * width;
    result.insert(result.end(), of_point, of_point + width);
  }
  return result;
}

}  // namespace

template <int dim>
std::int64_t MpmOutput<dim>::frame_bytes(std::int64_t num_points) {
  return XdmfSeries::frame_bytes(num_points, CellType::point1, num_points, frame_fields<dim>({}));
}

template <int dim>
MpmOutput<dim>::MpmOutput(MPI_Comm comm, const std::string& folder)
    : comm_(comm), writes_(!folder.empty()) {
  if (writes_ && rank_of(comm) == 0) series_ = std::make_unique<XdmfSeries>(folder, "soil");
}

template <int dim>
void MpmOutput<dim>::write(double time, const MaterialPoints<dim>& points) {
  if (!writes_) return;
  const std::size_t n = points.x.size();
  std::vector<double> body(n), pressure(n), plastic(n), volume(n), stress;
  stress.reserve(n * symmetric_size<dim>);
  for (std::int32_t b = 0; b < points.num_bodies(); ++b) {
    for (std::int32_t p = points.body_starts[b]; p < points.body_starts[b + 1]; ++p) body[p] = b;
  }
  for (std::size_t p = 0; p < n; ++p) {
    const Symmetric<dim> sigma = points.tau[p] / points.J[p];
    stress.insert(stress.end(), sigma.data(), sigma.data() + sigma.size());
    pressure[p] = -(sigma[0] + sigma[1] + sigma[2]) / 3;
    plastic[p] = points.history[p].plastic_strain;
    volume[p] = points.V0[p] * points.J[p];
  }
  const auto order = order_of(gather<std::int64_t>(comm_, points.id));
  const auto all = [&](Values own) { return ordered(order, gather<double>(comm_, own)); };
  const auto x = all(flat(points.x));
  const auto u = all(flat(points.u));
  const auto v = all(flat(points.v));
  body = all(body);
  pressure = all(pressure);
  plastic = all(plastic);
  volume = all(volume);
  stress = all(stress);
  const auto J = all(points.J);
  if (!series_) return;
  series_->write({.time = time,
                  .dim = dim,
                  .coordinates = x,
                  .fields = frame_fields<dim>({.u = u,
                                               .v = v,
                                               .stress = stress,
                                               .pressure = pressure,
                                               .plastic_strain = plastic,
                                               .J = J,
                                               .volume = volume,
                                               .body = body})});
}

template class MpmOutput<2>;
template class MpmOutput<3>;

}  // namespace gabion::mpm
