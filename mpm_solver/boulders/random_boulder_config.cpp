// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/boulders/random_boulder_config.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/base/error.hpp"
#include "common/base/log.hpp"
#include "mpm_solver/boulders/boulder_law_config.hpp"
#include "mpm_solver/boulders/polygon.hpp"
#include "mpm_solver/boulders/random_places.hpp"

namespace gabion::mpm {

namespace {

constexpr double pi = std::numbers::pi;
constexpr std::size_t most_boulders = 10000;

KeyTable region_keys() {
  return {"random_region",
          "Region in which a sphere around each boulder lies wholly.",
          {key::vector("low", "m", "Corner of a box along the axes.").with("high").or_none(),
           key::vector("high", "m", "The opposite corner.").with("low").or_none(),
           key::rows("polygon", "m", "Corners [x, y] of a polygon, in 3D of its outline in plan.")
               .wide(2, 2)
               .not_empty(3)
               .or_none(),
           key::vector("heights", "m", "Lowest and highest z over the polygon.")
               .wide(2, 2)
               .with("polygon")
               .or_none()
               .only("in 3D")},
          {"low", "polygon"}};
}

KeyTable size_keys() {
  const KeyTable lognormal{
      "lognormal_sizes",
      "Lognormal distribution by number, truncated at the limits.",
      {key::number("median", "m", "Median of the distribution before it is truncated.")
           .in(positive()),
       key::number("deviation", "", "Standard deviation of the natural logarithm.").in(positive()),
       key::number("min", "m", "Smallest size.").in(positive()),
       key::number("max", "m", "Largest size.").in(positive())}};
  return {
      "random_sizes",
      "Sizes of the boulders: diameters of spheres (2D: discs) of the same volume.",
      {key::vector("uniform", "m", "[smallest, largest], all sizes equally likely by number.")
           .in(positive())
           .wide(2, 2)
           .or_none(),
       key::object("lognormal", lognormal, "A lognormal distribution.").or_none(),
       key::rows("grading", "m, 1",
                 "Curve of [size, share of the mass that is finer], ascending from share 0 to 1, "
                 "linear in the logarithm of the size.")
           .wide(2, 2)
           .not_empty(2)
           .or_none()},
      {"uniform", "lognormal", "grading"}};
}

UniformSizes limits_of(ConfigReader& in, const std::string& key, double min, double max) {
  if (min > max) {
    in.fail(key, fmt::format("found a smallest size of {} m above the largest of {} m, allowed: "
                             "the smallest first",
                             min, max));
  }
  return {.min = min, .max = max};
}

GradedSizes read_grading(ConfigReader& in) {
  GradedSizes sizes;
  for (const auto& row : in.rows("grading", 2)) sizes.curve.push_back({row[0], row[1]});
  const auto& curve = sizes.curve;
  const auto refuse_unless = [&](bool good, std::size_t k) {
    if (good) return;
    const std::string after =
        k == 0 ? "" : fmt::format(" after [{}, {}]", curve[k - 1][0], curve[k - 1][1]);
    in.fail(fmt::format("grading/{}", k),
            fmt::format("found [{}, {}]{}, allowed: sizes above 0 that rise, with shares that rise "
                        "from 0 to 1",
                        curve[k][0], curve[k][1], after));
  };
  refuse_unless(curve.front()[0] > 0 && curve.front()[1] == 0, 0);
  for (std::size_t k = 1; k < curve.size(); ++k) {
    refuse_unless(curve[k][0] > curve[k - 1][0] && curve[k][1] >= curve[k - 1][1], k);
  }
  refuse_unless(curve.back()[1] == 1, curve.size() - 1);
  return sizes;
}

SizeDistribution read_sizes(ConfigReader in) {
  const bool uniform = in.has("uniform"), grading = in.has("grading");
  if (uniform + grading + in.has("lognormal") != 1) {
    in.fail("uniform", "allowed: exactly one of uniform, lognormal, grading");
  }
  SizeDistribution sizes;
  if (uniform) {
    const auto ends = in.vector("uniform", 2);
    sizes = limits_of(in, "uniform", ends[0], ends[1]);
  } else if (grading) {
    sizes = read_grading(in);
  } else {
    ConfigReader own = in.object("lognormal");
    LognormalSizes read{.median = own.number("median"), .deviation = own.number("deviation")};
    read.min = own.number("min");
    read.max = own.number("max");
    limits_of(own, "min", read.min, read.max);
    own.finish();
    sizes = read;
  }
  in.finish();
  return sizes;
}

template <int dim>
void read_polygon(ConfigReader& in, RandomRegion<dim>& region) {
  for (const auto& row : in.rows("polygon", 2)) region.polygon.emplace_back(row[0], row[1]);
  try {
    require_simple(region.polygon);
  } catch (const ConfigError& error) {
    in.fail("polygon", error.what());
  }
  for (const Vector<2>& corner : region.polygon) {
    Vector<dim> x = Vector<dim>::Zero();
    x.template head<2>() = corner;
    region.box.extend(x);
  }
  if (dim == 2) {
    if (in.has("heights")) in.fail("heights", "allowed only in 3D");
    return;
  }
  if (!in.has("heights")) {
    in.fail("heights", "missing, allowed in 3D: [lowest, highest] z over the polygon");
  }
  const auto heights = in.vector("heights", 2);
  region.box.min()[dim - 1] = heights[0];
  region.box.max()[dim - 1] = heights[1];
}

template <int dim>
RandomRegion<dim> read_region(ConfigReader in) {
  RandomRegion<dim> region;
  const bool is_box = in.has("low");
  if (is_box != in.has("high")) {
    in.fail(is_box ? "high" : "low", "missing, allowed: low and high, or a polygon");
  }
  if (is_box == in.has("polygon")) {
    in.fail("low", "allowed: either low and high, or a polygon");
  }
  if (is_box) {
    const auto low = in.vector("low", dim), high = in.vector("high", dim);
    std::copy(low.begin(), low.end(), region.box.min().data());
    std::copy(high.begin(), high.end(), region.box.max().data());
  } else {
    read_polygon(in, region);
  }
  if (!(region.box.sizes().minCoeff() > 0) || !(region.volume() > 0)) {
    in.fail(is_box ? "high" : "polygon",
            "found a region without volume, allowed: every coordinate of `high` above that of "
            "`low`, corners of a polygon in order, the higher of `heights` last");
  }
  in.finish();
  return region;
}

enum class Kind { sphere, box, ellipsoid };

/// Settings that the shapes of an entry have in common.
struct RandomShape {
  Kind kind = Kind::sphere;
  double density = 0;
  std::vector<std::vector<double>> ratios;  // ranges of b/a and c/b
};

template <int dim>
RandomShape read_random_shape(ConfigReader& in) {
  const std::string kind = in.choice("shape");
  RandomShape shape{.kind = kind == "sphere" ? Kind::sphere
                            : kind == "box"  ? Kind::box
                                             : Kind::ellipsoid,
                    .density = in.number("density"),
                    .ratios = {}};
  if (!in.has("axis_ratios")) {
    shape.ratios.assign(dim - 1, {1, 1});
    return shape;
  }
  if (shape.kind == Kind::sphere) in.fail("axis_ratios", "allowed only with a box or an ellipsoid");
  shape.ratios = in.rows("axis_ratios", 2);
  bool allowed = shape.ratios.size() == dim - 1;
  for (const auto& range : shape.ratios) {
    allowed &= range[0] > 0 && range[0] <= range[1] && range[1] <= 1;
  }
  if (!allowed) {
    in.fail("axis_ratios",
            fmt::format("allowed in {}D: {} of [low, high], 0 < low <= high <= 1", dim, dim - 1));
  }
  return shape;
}

// A shape of the volume of a sphere of this diameter.
template <int dim>
BoulderShape<dim> draw_shape(const RandomShape& of, double size, RandomNumbers& random) {
  if (of.kind == Kind::sphere) return sphere_shape<dim>(0.5 * size, of.density);
  Vector<dim> axes = Vector<dim>::Ones();  // over the longest
  for (int d = 1; d < dim; ++d) {
    axes[d] = axes[d - 1] * random.between(of.ratios[d - 1][0], of.ratios[d - 1][1]);
  }
  const double sphere = dim == 2 ? pi / 4 : pi / 6;
  const double full = of.kind == Kind::box ? 1 : sphere;
  axes *= size * std::pow(sphere / (full * axes.prod()), 1. / dim);
  return of.kind == Kind::box ? box_shape<dim>(axes, of.density)
                              : ellipsoid_shape<dim>(0.5 * axes, of.density);
}

template <int dim>
Eigen::Quaterniond draw_orientation(RandomNumbers& random) {
  if (dim == 2) {
    return Eigen::Quaterniond(Eigen::AngleAxisd(random.between(0, 2 * pi), Vector<3>::UnitZ()));
  }
  Eigen::Quaterniond q;
  for (double& part : q.coeffs()) part = random.normal();
  return q.normalized();
}

double volume_of(double size, int dim) {
  return dim == 2 ? pi / 4 * size * size : pi / 6 * size * size * size;
}

// Sizes, the largest first, so that the largest boulders find room [m].
std::vector<double> draw_sizes(ConfigReader& in, int dim, double region, RandomNumbers& random) {
  const bool counted = in.has("count");
  if (counted == in.has("volume_share")) {
    in.fail("count", "allowed: either count or volume_share");
  }
  const auto wanted = counted ? static_cast<std::size_t>(in.integer("count")) : most_boulders;
  const double volume = counted ? 0 : region * in.number("volume_share");
  const SizeDistribution distribution = read_sizes(in.object("sizes"));
  std::vector<double> sizes;
  double sum = 0;
  while (sizes.size() < wanted) {
    double size = 0;
    try {
      size = draw_size(distribution, dim, random);
    } catch (const ConfigError& error) {
      in.fail("sizes", error.what());
    }
    // The volume is as near to the wanted one as whole boulders come.
    if (!counted && sum + 0.5 * volume_of(size, dim) > volume) break;
    sizes.push_back(size);
    sum += volume_of(size, dim);
  }
  if (sizes.empty()) {
    in.fail("volume_share", fmt::format("found {:.4g} m^{}, less than half of a boulder, allowed: "
                                        "room for one",
                                        volume, dim));
  }
  if (!counted && sizes.size() == most_boulders) {
    in.fail("volume_share", fmt::format("found more than {} boulders, allowed: larger sizes or a "
                                        "smaller share",
                                        most_boulders));
  }
  std::sort(sizes.begin(), sizes.end(), std::greater<>());
  return sizes;
}

template <int dim>
void log_boulders(const std::string& name, const std::vector<BoulderSettings<dim>>& drawn,
                  double region, const typename RandomPlaces<dim>::Rejected& rejected) {
  double mass = 0, least = std::numeric_limits<double>::infinity(), most = 0;
  for (const auto& boulder : drawn) {
    const double volume = boulder.shape.mass.mass / boulder.density;
    const double size = std::pow(volume / volume_of(1, dim), 1. / dim);
    mass += boulder.shape.mass.mass;
    least = std::min(least, size);
    most = std::max(most, size);
  }
  const double volume = mass / drawn.front().density;
  log::info(
      "{}: {} random boulders of {:.4g} to {:.4g} m, together {:.6g} kg and {:.4g} m^{}, {:.3g} of "
      "the region; {} draws were rejected: {} left the region, {} overlapped boulders, {} surfaces",
      name, drawn.size(), least, most, mass, volume, dim, volume / region, rejected.total(),
      rejected.out_of_region, rejected.at_boulder, rejected.at_surface);
}

}  // namespace

KeyTable random_boulder_keys() {
  const double most = most_boulders;
  KeyTable table{
      "random_boulders",
      "Boulders of random size, shape, place and orientation, none touching another or a surface.",
      {key::plain_name("Start of the boulders' names: NAME_1, NAME_2, ..., the largest first."),
       key::integer("count", "Number of boulders.").in(between(1, most)).or_none(),
       key::number("volume_share", "", "Volume of the boulders over that of the region.")
           .in(inside(0, 1))
           .or_none(),
       key::object("region", region_keys(), "Where they are placed."),
       key::object("sizes", size_keys(), "How large they are."),
       key::choice("shape", {"sphere", "box", "ellipsoid"}, "Shape of all of them.")
           .or_else("sphere"),
       key::rows("axis_ratios", "",
                 "Ranges [low, high] of middle over longest length and, in 3D, shortest over "
                 "middle; none: 1.")
           .wide(2, 2)
           .or_none(),
       key::number("minimum_distance", "m",
                   "Smallest distance between the spheres around two boulders, or between such a "
                   "sphere and a surface.")
           .in(non_negative())
           .or_else(0),
       key::integer("seed",
                    "Seed of the random numbers; entries with the same seed draw the same numbers.")
           .in(non_negative())
           .or_else(1),
       key::number("stiffness", "N/m^2",
                   fmt::format("Contact force on a hard body (wall, structure, boulder) over the "
                               "square of the penetration; none: for each boulder the one that {}.",
                               usual_stiffness_words()))
           .in(positive())
           .or_none()},
      {"count", "volume_share"}};
  const auto others = boulder_law_keys();
  table.keys.insert(table.keys.end(), others.begin(), others.end());
  return table;
}

template <int dim>
std::vector<BoulderSettings<dim>> read_random_boulders(ConfigReader& in,
                                                       const BoulderScene<dim>& among) {
  const std::string name = in.name("name");
  const auto region = read_region<dim>(in.object("region"));
  RandomNumbers random(static_cast<std::uint64_t>(in.integer("seed")));
  const RandomShape shape = read_random_shape<dim>(in);
  const auto sizes = draw_sizes(in, dim, region.volume(), random);
  RandomPlaces<dim> places(region, among, in.number("minimum_distance"));
  const auto velocity = in.vector("velocity", dim);
  std::vector<BoulderSettings<dim>> drawn;
  for (std::size_t k = 0; k < sizes.size(); ++k) {
    BoulderSettings<dim>& boulder = drawn.emplace_back();
    boulder.name = fmt::format("{}_{}", name, k + 1);
    boulder.where = in.where("region");
    boulder.density = shape.density;
    boulder.shape = draw_shape<dim>(shape, sizes[k], random);
    read_boulder_law(in, boulder);
    boulder.law.stiffness =
        in.optional_number("stiffness").value_or(usual_stiffness(boulder.shape));
    if (shape.kind != Kind::sphere) boulder.start.q = draw_orientation<dim>(random);
    std::copy(velocity.begin(), velocity.end(), boulder.start.v.begin());
    try {
      boulder.start.x.template head<dim>() = places.draw(boulder.shape.radius, random);
    } catch (const ConfigError& error) {
      in.fail("region", fmt::format("boulder {} of {}: {}", k + 1, sizes.size(), error.what()));
    }
  }
  in.finish();
  log_boulders<dim>(name, drawn, region.volume(), places.rejected());
  return drawn;
}

template std::vector<BoulderSettings<2>> read_random_boulders<2>(ConfigReader&,
                                                                 const BoulderScene<2>&);
template std::vector<BoulderSettings<3>> read_random_boulders<3>(ConfigReader&,
                                                                 const BoulderScene<3>&);

}  // namespace gabion::mpm
