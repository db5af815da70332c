// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/report/mpm_output.hpp"

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
  const auto x = gather<double>(comm_, flat(points.x));
  const auto u = gather<double>(comm_, flat(points.u));
  const auto v = gather<double>(comm_, flat(points.v));
  body = gather<double>(comm_, body);
  pressure = gather<double>(comm_, pressure);
  plastic = gather<double>(comm_, plastic);
  volume = gather<double>(comm_, volume);
  stress = gather<double>(comm_, stress);
  const auto J = gather<double>(comm_, points.J);
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
