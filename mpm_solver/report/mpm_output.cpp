// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/report/mpm_output.hpp"

#include <algorithm>
#include <functional>
#include <numeric>
#include <utility>

#include "common/mechanics/ranks/gather.hpp"
#include "mpm_solver/points/flat.hpp"

namespace gabion::mpm {

namespace {

using Values = std::vector<double>;

// Of the points of this rank. The fields refer to them.
template <int dim>
std::vector<OutputField> frame_fields(const MaterialPoints<dim>& points) {
  const auto of_each = [&points](auto value) {
    return [&points, value] {
      Values values;
      values.reserve(points.x.size());
      for (std::int32_t p = 0; p < points.size(); ++p) values.push_back(value(p));
      return values;
    };
  };
  const auto copy = [](std::span<const double> values) {
    return Values(values.begin(), values.end());
  };
  const auto stress = [&points] {
    Values values;
    values.reserve(points.x.size() * symmetric_size<dim>);
    for (std::int32_t p = 0; p < points.size(); ++p) {
      const Symmetric<dim> sigma = points.tau[p] / points.J[p];
      values.insert(values.end(), sigma.data(), sigma.data() + sigma.size());
    }
    return values;
  };
  const auto body = [&points] {
    Values values;
    values.reserve(points.x.size());
    for (std::int32_t b = 0; b < points.num_bodies(); ++b) {
      values.insert(values.end(), points.body_starts[b + 1] - points.body_starts[b], b);
    }
    return values;
  };
  const auto pressure = [&points](std::int32_t p) {
    const Symmetric<dim> sigma = points.tau[p] / points.J[p];
    return -(sigma[0] + sigma[1] + sigma[2]) / 3;
  };
  const auto field = [](std::string name, int components, std::function<Values()> make) {
    return OutputField{.name = std::move(name), .components = components, .make = std::move(make)};
  };
  return {
      field("displacement", dim, [&points, copy] { return copy(flat(points.u)); }),
      field("velocity", dim, [&points, copy] { return copy(flat(points.v)); }),
      field("stress", symmetric_size<dim>, stress),
      field("pressure", 1, of_each(pressure)),
      field("plastic_strain", 1,
            of_each([&points](std::int32_t p) { return points.history[p].plastic_strain; })),
      field("volume_ratio", 1, [&points] { return points.J; }),
      field("volume", 1, of_each([&points](std::int32_t p) { return points.V0[p] * points.J[p]; })),
      field("body", 1, body)};
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
  return XdmfSeries::frame_bytes(num_points, CellType::point1, num_points,
                                 frame_fields<dim>(MaterialPoints<dim>()));
}

template <int dim>
MpmOutput<dim>::MpmOutput(MPI_Comm comm, const std::string& folder)
    : comm_(comm), writes_(!folder.empty()) {
  if (writes_ && rank_of(comm) == 0) series_ = std::make_unique<XdmfSeries>(folder, "soil");
}

template <int dim>
void MpmOutput<dim>::write(double time, const MaterialPoints<dim>& points) {
  if (!writes_) return;
  const auto order = order_of(gather<std::int64_t>(comm_, points.id));
  const auto of_all = [&](Values own) {
    if (num_ranks(comm_) == 1) return ordered(order, std::move(own));
    Values all = gather<double>(comm_, own);
    own = {};
    return ordered(order, std::move(all));
  };
  std::vector<OutputField> fields = frame_fields(points);
  for (OutputField& field : fields) {
    field.make = [own = std::move(field.make), &of_all] { return of_all(own()); };
  }
  const auto x = flat(points.x);
  const Values x_of_all = of_all({x.begin(), x.end()});
  if (series_) {
    series_->write(
        {.time = time, .dim = dim, .coordinates = x_of_all, .fields = std::move(fields)});
  } else {
    for (const OutputField& field : fields) field.make();  // gathered in the same order
  }
}

template class MpmOutput<2>;
template class MpmOutput<3>;

}  // namespace gabion::mpm
