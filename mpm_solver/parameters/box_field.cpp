// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/parameters/box_field.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>

#include "common/base/require.hpp"
#include "common/hdf5/hdf5_reader.hpp"
#include "mpm_solver/parameters/interpolation.hpp"

namespace gabion::mpm {

namespace {

constexpr const char* axis_names[] = {"x", "y", "z"};

std::vector<double> read_axis(const std::string& path, const Hdf5Reader& file, const char* name) {
  std::vector<double> axis = file.numbers(name);
  require<ConfigError>(axis.size() >= 2 && std::isfinite(axis[0]),
                       "{}: dataset {}: found {} coordinates, allowed: at least 2, ascending", path,
                       name, axis.size());
  for (std::size_t k = 1; k < axis.size(); ++k) {
    require<ConfigError>(axis[k] > axis[k - 1] && std::isfinite(axis[k]),
                         "{}: dataset {}: found {} after {}, allowed: ascending coordinates", path,
                         name, axis[k], axis[k - 1]);
  }
  return axis;
}

// Interpolate along axis d and those after it. @param node  number of the lattice's node along the
// axes before
template <int dim>
double value_from_axis(const BoxField<dim>& field, int d, std::size_t node,
                       const std::array<PlaceBetween, dim>& place, const Vector<dim>& x) {
  if (d == dim) {
    require<ConfigError>(std::isfinite(field.values[node]),
                         "{}: dataset values: found {}, which a point at ({:.9g}) needs, allowed: "
                         "a number",
                         field.path, field.values[node], fmt::join(x.data(), x.data() + dim, ", "));
    return field.values[node];
  }
  return between(place[d], [&](int k) {
    const std::size_t next = node * field.axes[d].size() + place[d].first + k;
    return value_from_axis<dim>(field, d + 1, next, place, x);
  });
}

}  // namespace

template <int dim>
BoxField<dim> read_box_field(const std::string& path) {
  BoxField<dim> field{.path = path};
  try {
    const Hdf5Reader file(path);
    std::vector<std::int64_t> expected;
    for (int d = 0; d < dim; ++d) {
      field.axes[d] = read_axis(path, file, axis_names[d]);
      expected.push_back(std::ssize(field.axes[d]));
    }
    const auto shape = file.shape("values");
    require<ConfigError>(shape == expected,
                         "{}: dataset values: found the shape [{}], allowed: [{}], one value for "
                         "each x, y{} in this order",
                         path, fmt::join(shape, ", "), fmt::join(expected, ", "),
                         dim == 3 ? " and z" : "");
    field.values = file.numbers("values");
  } catch (const ConfigError&) {
    throw;
  } catch (const Error& error) {
    throw ConfigError(error.what());
  }
  return field;
}

template <int dim>
double BoxField<dim>::at(const Vector<dim>& x) const {
  std::array<PlaceBetween, dim> place;
  for (int d = 0; d < dim; ++d) {
    place[d] = place_between(x[d], axes[d]);
    require<ConfigError>(place[d].first >= 0,
                         "{}: it reaches from {} = {:.9g} to {:.9g}, found a point at {:.9g}", path,
                         axis_names[d], axes[d].front(), axes[d].back(), x[d]);
  }
  return value_from_axis<dim>(*this, 0, 0, place, x);
}

template struct BoxField<2>;
template struct BoxField<3>;
template BoxField<2> read_box_field<2>(const std::string&);
template BoxField<3> read_box_field<3>(const std::string&);

}  // namespace gabion::mpm
