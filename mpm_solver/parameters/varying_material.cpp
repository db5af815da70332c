// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/parameters/varying_material.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <utility>

#include "common/base/log.hpp"
#include "common/base/require.hpp"
#include "common/mechanics/materials/read_umat.hpp"
#include "common/settings/plausible.hpp"

namespace gabion::mpm {

const std::vector<std::string> may_vary = {"young_modulus", "friction_angle",  "dilation_angle",
                                           "cohesion",      "tension_cutoff",  "yield_stress",
                                           "consistency",   "static_friction", "limit_friction"};

namespace {

/// Reason why a number may not vary.
struct Fixed {
  const char* name;
  const char* reason;
};
constexpr Fixed fixed[] = {
    {"density", "bodies of their own have other densities"},
    {"poisson_ratio", "initial stress and the remedy for locking use one value per body"},
    {"viscosity", "a fluid mixes"},
    {"sound_speed", "a fluid mixes"},
    {"compression_index", "the state of clay varies with its pressure already"},
    {"swelling_index", "the state of clay varies with its pressure already"},
    {"critical_state_ratio", "the state of clay varies with its pressure already"},
    {"grain_size", "bodies of their own have other grains"},
    {"inertial_number", "bodies of their own have other grains"},
    {"grain_density", "bodies of their own have other grains"}};

bool varies(const std::string& name) {
  return std::ranges::find(may_vary, name) != may_vary.end();
}

const Key* find_key(const KeyTable& table, const std::string& name, KeyType type) {
  for (const Key& key : table.keys) {
    if (key.name == name && key.type == type) return &key;
  }
  return nullptr;
}

KeyTable layer_keys() {
  KeyTable table{"layer",
                 "Soil below a surface. Its constants replace those of the soil above; a constant "
                 "that it does not name stays the same.",
                 below_keys("Surface below which it lies.")};
  const KeyTable material = material_keys(material_laws);
  for (const std::string& name : may_vary) {
    Key number = *find_key(material, name, KeyType::number);
    number.conditions.clear();
    number.range = any_number();
    number.sentence = "Value in this layer.";
    table.keys.push_back(number.or_none());
    table.keys.push_back(
        key::object(name, value_source_keys(), "The same constant, varying in space.").or_none());
  }
  return table;
}

/// The given values of an object as JSON, defaults included; null in place of what varies.
Json copy_settings(ConfigReader& in, const KeyTable& table);

void copy_key(ConfigReader& in, const Key& key, Json& copy) {
  const bool given = in.has(key.name);
  if (!given && key.absence != Absence::refused && key.absence != Absence::fallback) return;
  switch (key.type) {
    case KeyType::number:
      if (given && varies(key.name) && in.is_object(key.name)) {
        copy[key.name] = nullptr;  // each place has its own
      } else {
        copy[key.name] = in.number(key.name);
      }
      return;
    case KeyType::choice:
      copy[key.name] = in.choice(key.name);
      return;
    case KeyType::rows:
      copy[key.name] = in.rows(key.name, static_cast<int>(key.min_width));
      return;
    case KeyType::object: {
      ConfigReader object = in.object(key.name);
      copy[key.name] = copy_settings(object, *key.table);
      object.finish();
      return;
    }
    default:
      throw std::logic_error("a material has a key of another type than a number: " + key.name);
  }
}

Json copy_settings(ConfigReader& in, const KeyTable& table) {
  Json copy = Json::object();
  for (const Key& key : table.keys) {
    const bool is_source = key.type == KeyType::object && varies(key.name);
    if (is_source || key.type == KeyType::objects) continue;
    if (applies(key, table, copy)) copy_key(in, key, copy);
  }
  return copy;
}

// Reader of a file that has the settings of one material alone.
ConfigReader file_of(const Json& settings, const std::string& file, std::size_t body) {
  static const KeyTable root = {
      "mpm",
      "",
      {key::objects("bodies",
                    {"body", "", {key::object("material", material_keys(material_laws), "")}},
                    "")}};
  Json bodies(body + 1, Json::object());
  bodies[body]["material"] = settings;
  const Json whole = {{"bodies", std::move(bodies)}};
  return {whole, file, root};
}

// Reader of the settings of a material at its place in the file.
ConfigReader reader_of(const Json& settings, const std::string& file, std::size_t body) {
  return file_of(settings, file, body).objects("bodies")[body].object("material");
}

}  // namespace

KeyTable varying_material_keys(const std::vector<std::string>& laws) {
  KeyTable table = material_keys(laws);
  const KeyTable numbers = table;
  for (const Key& number : numbers.keys) {
    if (number.type != KeyType::number || !varies(number.name)) continue;
    Key source =
        key::object(number.name, value_source_keys(), "The same constant, varying in space.");
    source.conditions = number.conditions;
    source.absence = number.absence == Absence::refused ? Absence::refused : Absence::none;
    table.keys.push_back(source);
  }
  table.keys.push_back(
      key::objects(
          "layers", layer_keys(),
          "Layers from top to bottom. A point has the constants of the last layer whose surface "
          "lies above it.")
          .or_none());
  return table;
}

/// Reads the parts of a VaryingMaterial.
template <int dim>
struct VaryingReader {
  const SourcePlace<dim>& place;
  const PointLayout<dim>& layout;
  VaryingMaterial<dim>& result;

  // Sources of one object, those first that others are correlated with.
  // @param names  keys that have an object in place of a number
  std::vector<NamedSource<dim>> read_sources(ConfigReader& in, const std::string& stream,
                                             const std::vector<std::string>& names) {
    std::vector<std::string> correlated;
    std::vector<NamedSource<dim>> sources;
    for (const std::string& name : names) {
      if (is_correlated(in.object(name))) {
        correlated.push_back(name);
        continue;
      }
      sources.push_back({name, read_value_source<dim>(in.object(name), stream + name, place, {})});
    }
    const std::vector<NamedSource<dim>> independent = sources;
    for (const std::string& name : correlated) {
      sources.push_back(
          {name, read_value_source<dim>(in.object(name), stream + name, place, independent)});
    }
    return sources;
  }

  std::size_t column(const std::string& name) {
    const auto found = std::ranges::find(result.names_, name);
    const auto number = static_cast<std::size_t>(found - result.names_.begin());
    if (found == result.names_.end()) result.names_.push_back(name);
    return number;
  }

  void read_layer(ConfigReader& item, const std::string& stream) {
    typename VaryingMaterial<dim>::Layer layer{.below = HeightSurface<dim>::read(item, place),
                                               .sources = {},
                                               .where = item.where("below")};
    std::vector<std::string> numbers, objects;
    for (const std::string& name : may_vary) {
      if (item.has(name)) (item.is_object(name) ? objects : numbers).push_back(name);
    }
    std::vector<NamedSource<dim>> sources = read_sources(item, stream, objects);
    for (const std::string& name : numbers) {
      sources.push_back({name, {.mean = item.number(name), .random = std::nullopt}});
    }
    for (NamedSource<dim>& source : sources) {
      if (!result.settings_.contains(source.name)) {
        item.fail(source.name,
                  "found, but none in the material itself, allowed: a constant that the soil above "
                  "the first layer has too");
      }
      layer.sources.emplace(column(source.name), std::move(source.source));
    }
    item.finish();
    result.layers_.push_back(std::move(layer));
  }

  void read(ConfigReader in) {
    const KeyTable table = varying_material_keys(material_laws);
    result.file_ = in.file();
    result.body_name_ = place.body;
    result.settings_ = copy_settings(in, table);
    std::vector<std::string> objects;
    for (const auto& item : result.settings_.items()) {
      if (item.value().is_null()) objects.push_back(item.key());
    }
    const std::vector<NamedSource<dim>> sources = read_sources(in, place.body + "/", objects);
    for (const NamedSource<dim>& source : sources) column(source.name);
    if (in.has("layers")) {
      auto items = in.objects("layers");
      for (std::size_t k = 0; k < items.size(); ++k) {
        read_layer(items[k], fmt::format("{}/layers/{}/", place.body, k));
      }
    }
    in.finish();
    if (result.names_.size() > most_varying) {
      in.fail(result.names_.back(),
              fmt::format("found {} constants that vary ({}), allowed: {}", result.names_.size(),
                          fmt::join(result.names_, ", "), most_varying));
    }
    for (const std::string& name : result.names_) {
      const auto found = std::ranges::find(sources, name, &NamedSource<dim>::name);
      if (found != sources.end()) {
        result.sources_.push_back(found->source);
      } else {  // constant above the layers
        result.sources_.push_back(
            {.mean = result.settings_.at(name).template get<double>(), .random = std::nullopt});
      }
    }
  }

  // Warn of values that look as if they had another unit.
  void warn_of_implausible(const VaryingParameters& values) const {
    Json settings = result.settings_;
    for (std::size_t k = 0; k < result.names_.size(); ++k) {
      settings[result.names_[k]] = values[static_cast<Eigen::Index>(k)];
    }
    ConfigReader whole = file_of(settings, result.file_, result.body_);
    ConfigReader in = whole.objects("bodies")[result.body_].object("material");
    for (const std::string& name : result.names_) in.number(name);
    warn_of_implausible_settings(whole, Described::soil);
  }

  // Give the body the law of its stiffest point.
  void choose_law(std::size_t number, Body<dim>& body) {
    result.body_ = number;
    double stiffest = 0;
    std::optional<VaryingParameters> least, largest;
    std::vector<char> is_used(result.layers_.size(), 0);
    result.for_each_point(layout, [&](const auto& point) {
      const auto [M, symmetric] = std::visit(
          [](const auto& law) { return std::pair(law.p_wave_modulus(), law.symmetric_tangent()); },
          point.material.law);
      result.symmetric_ &= symmetric;
      least = least ? least->cwiseMin(point.values).eval() : point.values;
      largest = largest ? largest->cwiseMax(point.values).eval() : point.values;
      for (const int layer : result.layers_at(point.x)) {
        if (layer >= 0) is_used[layer] = 1;
      }
      if (!(M > stiffest)) return;
      stiffest = M;
      body.material = point.material;
    });
    body.varying = result.names_;
    warn_of_implausible(*least);
    if (*largest != *least) warn_of_implausible(*largest);
    for (std::size_t k = 0; k < is_used.size(); ++k) {
      if (is_used[k] != 0) continue;
      log::warn(
          "{}: no material point of \"{}\" has the constants of this layer; layers are given from "
          "top to bottom, and the last one whose surface lies above a point counts",
          result.layers_[k].where, place.body);
    }
  }
};

template <int dim>
std::array<int, most_varying> VaryingMaterial<dim>::layers_at(const Vector<dim>& x) const {
  std::array<int, most_varying> layer;
  layer.fill(-1);
  for (std::size_t k = 0; k < layers_.size(); ++k) {
    if (!(x[dim - 1] < layers_[k].below.at(x))) continue;
    for (const auto& [column, source] : layers_[k].sources) layer[column] = static_cast<int>(k);
  }
  return layer;
}

template <int dim>
VaryingParameters VaryingMaterial<dim>::at(const Vector<dim>& x) const {
  VaryingParameters values = VaryingParameters::Zero();
  const auto layer = layers_at(x);
  for (std::size_t k = 0; k < sources_.size(); ++k) {
    const ValueSource<dim>& source = layer[k] < 0 ? sources_[k] : layers_[layer[k]].sources.at(k);
    values[static_cast<Eigen::Index>(k)] = source.at(x);
  }
  return values;
}

template <int dim>
Material<dim> VaryingMaterial<dim>::with(const VaryingParameters& values) const {
  Json settings = settings_;
  for (std::size_t k = 0; k < names_.size(); ++k) {
    settings[names_[k]] = values[static_cast<Eigen::Index>(k)];
  }
  return read_material<dim>(reader_of(settings, file_, body_));
}

template <int dim>
std::string VaryingMaterial<dim>::place_of(std::int64_t id, const Vector<dim>& x) const {
  return fmt::format("material point {} of \"{}\" at ({:.6g})", id, body_name_,
                     fmt::join(x.data(), x.data() + dim, ", "));
}

template <int dim>
void VaryingMaterial<dim>::for_each_point(const PointLayout<dim>& layout,
                                          const std::function<void(const Point&)>& visit) const {
  MaterialPoints<dim> points;
  lay_points<dim>(layout, 1, {}, points);
  std::optional<VaryingParameters> last;
  Material<dim> material;
  for (std::int32_t p = 0; p < points.size(); ++p) {
    const Vector<dim>& x = points.x[p];
    try {
      const VaryingParameters values = at(x);
      if (!last || *last != values) material = with(values);
      last = values;
    } catch (const ConfigError& error) {
      throw ConfigError(fmt::format("{}; {}", error.what(), place_of(points.id[p], x)));
    }
    visit({points.id[p], x, *last, material});
  }
}

template <int dim>
std::shared_ptr<const VaryingMaterial<dim>> read_body_material(ConfigReader in,
                                                               const SourcePlace<dim>& place,
                                                               std::size_t number,
                                                               const PointLayout<dim>& layout,
                                                               Body<dim>& body) {
  const ConfigReader look = in;  // what it is asked for does not count as read
  for (const Fixed& each : fixed) {
    if (!look.has(each.name) || !look.is_object(each.name)) continue;
    in.fail(each.name, fmt::format("found an object, allowed: a number; it does not vary: {}. "
                                   "These may: {}",
                                   each.reason, fmt::join(may_vary, ", ")));
  }
  const bool any = look.has("layers") || std::ranges::any_of(may_vary, [&](const auto& name) {
                     return look.has(name) && look.is_object(name);
                   });
  if (!any) {
    in.has("layers");
    body.material = read_material_in<dim>(place.scene.folder(), std::move(in));
    return nullptr;
  }
  if (in.choice("law") == "umat") {
    in.fail("law", "found \"umat\" with constants that vary, allowed: a law of the project's own");
  }
  auto varying = std::make_shared<VaryingMaterial<dim>>();
  VaryingReader<dim> reader{place, layout, *varying};
  reader.read(std::move(in));
  if (varying->names().empty()) {  // an empty list of layers
    body.material = varying->with(VaryingParameters::Zero());
    return nullptr;
  }
  reader.choose_law(number, body);
  return varying;
}

template <int dim>
void require_one_stiffness(const ConfigReader& in, const Body<dim>& body) {
  if (!body.water->drains()) return;
  if (std::ranges::find(body.varying, "young_modulus") == body.varying.end()) return;
  in.fail("material/young_modulus",
          "found values that vary beside \"water\" that drains, allowed: a number, or water "
          "without \"permeability\"");
}

template class VaryingMaterial<2>;
template class VaryingMaterial<3>;
template std::shared_ptr<const VaryingMaterial<2>> read_body_material<2>(
    ConfigReader, const SourcePlace<2>&, std::size_t, const PointLayout<2>&, Body<2>&);
template std::shared_ptr<const VaryingMaterial<3>> read_body_material<3>(
    ConfigReader, const SourcePlace<3>&, std::size_t, const PointLayout<3>&, Body<3>&);
template void require_one_stiffness<2>(const ConfigReader&, const Body<2>&);
template void require_one_stiffness<3>(const ConfigReader&, const Body<3>&);

}  // namespace gabion::mpm
