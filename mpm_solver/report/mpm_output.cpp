// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/report/mpm_output.hpp"

#include <algorithm>
#include <functional>
#include <set>
#include <utility>
#include <variant>

#include "common/mechanics/output/numbered_rows.hpp"
#include "mpm_solver/points/flat.hpp"

namespace gabion::mpm {

namespace {

using Values = std::vector<double>;

// Names of the internal variables of a law; none: it remembers none.
template <int dim>
std::vector<std::string> internal_names(const MaterialLaw<dim>& law) {
  return std::visit(
      []<class Law>(const Law&) -> std::vector<std::string> {
        if constexpr (RemembersInternal<Law>) {
          return {Law::internal_names[0], Law::internal_names[1]};
        } else {
          return {};
        }
      },
      law);
}

// Numbers of the points of this rank that their bodies name, 0 in bodies without the name.
// @param names_of  of a body: names_of(body), each its column
// @param value     value(point, column)
template <int dim, class NamesOf, class Value>
std::vector<OutputField> named_fields(const MaterialPoints<dim>& points,
                                      const std::vector<Body<dim>>& bodies, const NamesOf& names_of,
                                      const Value& value) {
  std::set<std::string> names;
  for (const Body<dim>& body : bodies) {
    for (const std::string& name : names_of(body)) names.insert(name);
  }
  std::vector<OutputField> fields;
  for (const std::string& name : names) {
    const auto make = [&points, &bodies, names_of, value, name] {
      Values values(points.x.size(), 0.0);
      for (std::int32_t b = 0; b < points.num_bodies(); ++b) {
        const std::vector<std::string> own = names_of(bodies[b]);
        const auto column = std::ranges::find(own, name) - own.begin();
        if (column == std::ssize(own)) continue;
        for (std::int32_t p = points.body_starts[b]; p < points.body_starts[b + 1]; ++p) {
          values[p] = value(p, column);
        }
      }
      return values;
    };
    fields.push_back({.name = name, .components = 1, .make = make});
  }
  return fields;
}

// Internal variables of laws, and constants that vary.
template <int dim>
std::vector<OutputField> fields_of_laws(const MaterialPoints<dim>& points,
                                        const std::vector<Body<dim>>& bodies) {
  std::vector<OutputField> fields = named_fields(
      points, bodies, [](const Body<dim>& body) { return internal_names(body.material.law); },
      [&points](std::int32_t p, std::ptrdiff_t k) { return points.internal[p][k]; });
  for (OutputField& varying : named_fields(
           points, bodies, [](const Body<dim>&body) { return body.varying; },
           [&points](std::int32_t p, std::ptrdiff_t k) { return points.parameters[p][k]; })) {
    fields.push_back(std::move(varying));
  }
  return fields;
}

// Fields of the points of this rank, to which they refer.
template <int dim>
std::vector<OutputField> frame_fields(const MaterialPoints<dim>& points,
                                      const std::vector<Body<dim>>& bodies) {
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
  std::vector<OutputField> fields = {
      field("displacement", dim, [&points, copy] { return copy(flat(points.u)); }),
      field("velocity", dim, [&points, copy] { return copy(flat(points.v)); }),
      field("stress", symmetric_size<dim>, stress),
      field("pressure", 1, of_each(pressure)),
      field("plastic_strain", 1,
            of_each([&points](std::int32_t p) { return points.history[p].plastic_strain; })),
      field("volume_ratio", 1, [&points] { return points.J; }),
      field("volume", 1, of_each([&points](std::int32_t p) { return points.V0[p] * points.J[p]; })),
      field("body", 1, body)};
  for (OutputField& own : fields_of_laws(points, bodies)) fields.push_back(std::move(own));
  return fields;
}

}  // namespace

template <int dim>
std::vector<OutputField> MpmOutput<dim>::fields(const MaterialPoints<dim>& points) const {
  std::vector<OutputField> all = frame_fields<dim>(points, bodies_);
  for (OutputField& field : more_(points)) all.push_back(std::move(field));
  return all;
}

template <int dim>
std::int64_t MpmOutput<dim>::frame_bytes(std::int64_t num_points) const {
  return XdmfSeries::frame_bytes(num_points, CellType::point1, num_points,
                                 fields(MaterialPoints<dim>()));
}

template <int dim>
MpmOutput<dim>::MpmOutput(MPI_Comm comm, const std::string& folder,
                          const std::vector<Body<dim>>& bodies, MoreFields more)
    : comm_(comm), bodies_(bodies), more_(std::move(more)) {
  if (!folder.empty()) series_.emplace(folder, "soil", comm);
}

template <int dim>
void MpmOutput<dim>::write(double time, const MaterialPoints<dim>& points) {
  if (!series_) return;
  const NumberedRows rows(comm_, points.id, points.body_ids.back());
  std::vector<OutputField> all = fields(points);
  for (OutputField& field : all) {
    field.make = [own = std::move(field.make), &rows, width = field.components] {
      return rows.gather_rows(own(), width);
    };
  }
  const auto x = flat(points.x);
  const Values x_of_rows = rows.gather_rows(Values(x.begin(), x.end()), dim);
  series_->write({.time = time, .dim = dim, .coordinates = x_of_rows, .fields = std::move(all)});
}

template class MpmOutput<2>;
template class MpmOutput<3>;

}  // namespace gabion::mpm
