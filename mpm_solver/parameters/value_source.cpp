// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/parameters/value_source.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "common/base/require.hpp"
#include "mpm_solver/parameters/interpolation.hpp"

namespace gabion::mpm {

namespace {

// Largest step of the lattice of a random field over the correlation length, and the default.
constexpr double largest_step = 0.25, usual_step = 0.125;

template <int dim>
std::shared_ptr<const Raster> read_raster_of(ConfigReader& in, const SourcePlace<dim>& place) {
  if (dim == 2) {
    in.fail("raster",
            "found in a section, allowed: in 3D, since a raster has a value for each place in "
            "plan; a section takes \"field\", or for a surface \"line\"");
  }
  return std::make_shared<const Raster>(
      read_raster(place.scene.path(in.text("raster")), place.origin.template head<2>()));
}

/// Columns of rows with an ascending first one.
struct Columns {
  std::vector<double> first, second;
};

Columns read_columns(ConfigReader& in, const std::string& key, const char* what) {
  Columns columns;
  for (const auto& row : in.rows(key, 2)) {
    if (!columns.first.empty() && !(row[0] > columns.first.back())) {
      in.fail(fmt::format("{}/{}", key, columns.first.size()),
              fmt::format("found {} {} after {}, allowed: rows whose {} ascends", what, row[0],
                          columns.first.back(), what));
    }
    columns.first.push_back(row[0]);
    columns.second.push_back(row[1]);
  }
  if (columns.first.size() < 2) in.fail(key, "found one row, allowed: at least 2 rows");
  return columns;
}

KeyTable correlation_keys() {
  return {
      "correlated_with",
      "Another key of the same object with a random field of the same correlation lengths.",
      {key::text("key", "Name of that key."),
       key::number("coefficient", "", "Correlation of the two normal fields.").in(inside(-1, 1))}};
}

KeyTable random_keys() {
  return {
      "random",
      "Lognormal random field with Markov's correlation exp(-2 |dx| / theta_x - 2 |dz| / theta_z); "
      "the same for every number of ranks.",
      {key::number("mean", "unit of the key", "Mean value.")
           .in(positive())
           .or_none()
           .only("where nothing else gives the mean, and then required"),
       key::number("cov", "", "Coefficient of variation: standard deviation over mean.")
           .in(positive()),
       key::vector("correlation_lengths", "m",
                   "Scales of fluctuation theta along the axes, the vertical one last.")
           .in(positive()),
       key::vector("step", "m",
                   fmt::format("Largest edges of the cells that have one value each, at most {:g} "
                               "of the correlation lengths; none: {:g} of them.",
                               largest_step, usual_step))
           .in(positive())
           .wide(2, 3)
           .or_none(),
       key::integer("seed",
                    "Seed of the random numbers. Fields with one seed are independent where body "
                    "or key differ.")
           .in(at_least(0)),
       key::object("correlated_with", correlation_keys(),
                   "Field with which this one is correlated; none: it is independent.")
           .or_none()}};
}

/// A random key that another one is correlated with.
template <int dim>
const RandomValues<dim>& correlated_field(ConfigReader& in, const std::string& name,
                                          const std::vector<NamedSource<dim>>& others) {
  std::vector<std::string> random;
  for (const NamedSource<dim>& other : others) {
    if (!other.source.random) continue;
    if (other.name == name) return *other.source.random;
    random.push_back(other.name);
  }
  in.fail("key",
          fmt::format(
              "found \"{}\", allowed: a key of the same object with a random field "
              "that is not correlated itself: {}",
              name, random.empty() ? "there is none" : fmt::format("{}", fmt::join(random, ", "))));
}

template <int dim>
RandomValues<dim> read_random(ConfigReader in, const std::string& stream, bool has_mean,
                              const SourcePlace<dim>& place,
                              const std::vector<NamedSource<dim>>& others) {
  const auto mean = in.optional_number("mean");
  if (mean.has_value() == has_mean) {
    in.fail("mean", has_mean ? "found beside another source of the mean, allowed: one of them"
                             : "missing, allowed: a number > 0, or by_depth, raster or field "
                               "beside \"random\"");
  }
  const auto lengths = in.vector("correlation_lengths", dim);
  const Vector<dim> theta = Eigen::Map<const Vector<dim>>(lengths.data());
  Vector<dim> step = usual_step * theta;
  if (const auto given = in.optional_vector("step")) {
    if (given->size() != dim) {
      in.fail("step", fmt::format("found {} numbers, allowed: {}", given->size(), dim));
    }
    step = Eigen::Map<const Vector<dim>>(given->data());
  }
  if ((step.array() > largest_step * theta.array()).any()) {
    in.fail("step", fmt::format("found ({}), allowed: at most {:g} of the correlation lengths ({})",
                                fmt::join(step.data(), step.data() + dim, ", "), largest_step,
                                fmt::join(lengths, ", ")));
  }
  RandomValues<dim> values{.lattice = RandomLattice<dim>(place.box, step),
                           .correlation_lengths = theta,
                           .z = nullptr,
                           .law = Lognormal::of(mean.value_or(1), in.number("cov"))};
  if (values.lattice.num_cells() > most_random_cells) {
    in.fail("correlation_lengths",
            fmt::format("found ({}), for which the field needs {} cells, allowed: {} cells; a "
                        "larger \"step\" takes fewer",
                        fmt::join(lengths, ", "), values.lattice.num_cells(), most_random_cells));
  }
  const CountedRandom random(static_cast<std::uint64_t>(in.integer("seed")), stream);
  std::vector<double> z = normal_field<dim>(values.lattice, theta, random);
  if (auto item = in.optional_object("correlated_with")) {
    const RandomValues<dim>& other = correlated_field<dim>(*item, item->text("key"), others);
    const double rho = item->number("coefficient");
    if (other.correlation_lengths != theta || other.lattice.count != values.lattice.count) {
      item->fail("key",
                 "found a field with other correlation lengths or another step, allowed: the same");
    }
    const double rest = std::sqrt(1 - rho * rho);
    for (std::size_t i = 0; i < z.size(); ++i) z[i] = rho * (*other.z)[i] + rest * z[i];
    item->finish();
  }
  in.finish();
  values.z = std::make_shared<const std::vector<double>>(std::move(z));
  return values;
}

}  // namespace

KeyTable height_surface_keys() {
  KeyTable table{"height_surface",
                 "A surface with one height over each place in plan.",
                 {key::rows("line", "m, m", "Polyline of a section, rows [x, height].")
                      .not_empty(2)
                      .wide(2, 2)
                      .or_none(),
                  key::text("raster",
                            "ESRI ASCII grid of heights over coordinates of the world "
                            "(`origin`), bilinear; 3D.")
                      .or_none()}};
  table.one_of = {"line", "raster"};
  return table;
}

std::vector<Key> below_keys(const std::string& sentence) {
  return {key::number("below", "m", sentence + " Its height where it is level."),
          key::object("below", height_surface_keys(), sentence)};
}

template <int dim>
HeightSurface<dim> HeightSurface<dim>::read(ConfigReader& in, const SourcePlace<dim>& place) {
  HeightSurface surface;
  if (!in.is_object("below")) {
    surface.shape_ = in.number("below");
    return surface;
  }
  ConfigReader item = in.object("below");
  const bool has_line = item.has("line"), has_raster = item.has("raster");
  if (has_line == has_raster) {
    item.fail("line", fmt::format("found {} line and raster, allowed: exactly one of them",
                                  has_line ? "both" : "neither"));
  }
  if (has_raster) {
    surface.shape_ = read_raster_of(item, place);
  } else {
    if (dim == 3) item.fail("line", "found in 3D, allowed: in a section; 3D takes \"raster\"");
    Columns columns = read_columns(item, "line", "x");
    surface.shape_ = Line{item.where("line"), std::move(columns.first), std::move(columns.second)};
  }
  item.finish();
  return surface;
}

template <int dim>
double HeightSurface<dim>::at(const Vector<dim>& x) const {
  if (const double* level = std::get_if<double>(&shape_)) return *level;
  if (const auto* raster = std::get_if<std::shared_ptr<const Raster>>(&shape_)) {
    return (*raster)->at(x.template head<2>());
  }
  const Line& line = std::get<Line>(shape_);
  const PlaceBetween place = place_between(x[0], line.x);
  require<ConfigError>(place.first >= 0,
                       "{}: found a line from x = {} to {}, which does not reach a point at x = {}",
                       line.where, line.x.front(), line.x.back(), x[0]);
  return between(place, [&](int k) { return line.height[place.first + k]; });
}

template <int dim>
double DepthTable<dim>::at(const Vector<dim>& x) const {
  const double d = surface.at(x) - x[dim - 1];
  const PlaceBetween place = place_between(d, depth);
  require<ConfigError>(place.first >= 0,
                       "{}: found depths from {} to {}, and a point in the depth {:.9g}; allowed: "
                       "rows for all depths of the soil",
                       where, depth.front(), depth.back(), d);
  return between(place, [&](int k) { return value[place.first + k]; });
}

template <int dim>
double ValueSource<dim>::at(const Vector<dim>& x) const {
  const double trend = std::visit(
      [&x]<class Mean>(const Mean& source) {
        if constexpr (std::is_same_v<Mean, double>) {
          return source;
        } else if constexpr (std::is_same_v<Mean, DepthTable<dim>>) {
          return source.at(x);
        } else if constexpr (std::is_same_v<Mean, std::shared_ptr<const Raster>>) {
          return source->at(x.template head<2>());
        } else {
          return source->at(x);
        }
      },
      mean);
  return random ? trend * random->at(x) : trend;
}

KeyTable value_source_keys() {
  KeyTable table{
      "varying",
      "Values of a constant that varies in space, taken at the material points at the start: one "
      "of by_depth, raster, field; or random, beside one of them as a factor of mean 1.",
      {key::rows("by_depth", "m, unit of the key",
                 "Rows [depth, value], linear between; they have to cover the soil.")
           .not_empty(2)
           .wide(2, 2)
           .or_none(),
       key::text("raster",
                 "ESRI ASCII grid over coordinates of the world (`origin`), bilinear; "
                 "3D.")
           .or_none(),
       key::text("field",
                 "HDF5 file with the datasets `x`, `y`, in 3D `z` (coordinates of the "
                 "nodes of a box) and `values` [x, y, z], linear between.")
           .or_none(),
       key::object("random", random_keys(), "Random field.").or_none()}};
  for (Key& each : below_keys("Surface from which depths count.")) {
    table.keys.push_back(each.with("by_depth"));
  }
  return table;
}

bool is_correlated(ConfigReader in) {
  return in.has("random") && in.object("random").has("correlated_with");
}

template <int dim>
ValueSource<dim> read_value_source(ConfigReader in, const std::string& stream,
                                   const SourcePlace<dim>& place,
                                   const std::vector<NamedSource<dim>>& others) {
  ValueSource<dim> source;
  std::vector<std::string> given;
  for (const char* name : {"by_depth", "raster", "field"}) {
    if (in.has(name)) given.emplace_back(name);
  }
  if (given.size() > 1 || (given.empty() && !in.has("random"))) {
    in.fail(given.empty() ? "by_depth" : given.back(),
            fmt::format("found {}, allowed: exactly one of by_depth, raster, field, with or "
                        "without \"random\", or \"random\" alone",
                        given.empty() ? "none" : fmt::format("{}", fmt::join(given, ", "))));
  }
  const std::string trend = given.empty() ? "" : given.front();
  if (trend == "by_depth") {
    Columns columns = read_columns(in, "by_depth", "depth");
    source.mean = DepthTable<dim>{.where = in.where("by_depth"),
                                  .surface = HeightSurface<dim>::read(in, place),
                                  .depth = std::move(columns.first),
                                  .value = std::move(columns.second)};
  } else if (in.has("below")) {
    in.fail("below", "allowed only with \"by_depth\"");
  }
  if (trend == "raster") source.mean = read_raster_of(in, place);
  if (trend == "field") {
    source.mean = std::make_shared<const BoxField<dim>>(
        read_box_field<dim>(place.scene.path(in.text("field"))));
  }
  if (auto item = in.optional_object("random")) {
    source.random = read_random<dim>(std::move(*item), stream, !given.empty(), place, others);
  }
  in.finish();
  return source;
}

template class HeightSurface<2>;
template class HeightSurface<3>;
template struct DepthTable<2>;
template struct DepthTable<3>;
template struct ValueSource<2>;
template struct ValueSource<3>;
template ValueSource<2> read_value_source<2>(ConfigReader, const std::string&,
                                             const SourcePlace<2>&,
                                             const std::vector<NamedSource<2>>&);
template ValueSource<3> read_value_source<3>(ConfigReader, const std::string&,
                                             const SourcePlace<3>&,
                                             const std::vector<NamedSource<3>>&);

}  // namespace gabion::mpm
