// SPDX-License-Identifier: BSD-3-Clause
#include "element_test/element_settings.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>

#include "common/mechanics/materials/read_umat.hpp"

namespace gabion::element {

namespace {

const std::vector<std::string> normal_names(component_names.begin(), component_names.begin() + 3);

KeyTable component_keys(const std::string& name, const std::string& unit,
                        const std::string& sentence) {
  KeyTable table{name, sentence, {}};
  for (int k = 0; k < num_components; ++k) {
    Key key = key::number(component_names[k], unit, k < 3 ? "Normal component." : "Shear.");
    if (unit.empty() && k < 3) {
      key = key.in(
          {.high = 1, .high_open = true, .allowed = "a number below 1, compression positive"});
    }
    table.keys.push_back(key.or_none());
  }
  return table;
}

KeyTable stage_keys() {
  return {
      "stage",
      "Part of a test. Components that it names go linearly from their present value to the one "
      "here; the others keep their strain.",
      {key::plain_name("Unique name, for the table."),
       key::boolean("zero_strain",
                    "Whether strains are counted from the start of this stage, in later stages "
                    "too; else as before.")
           .or_else(false),
       key::object("strain",
                   component_keys("strain", "",
                                  "Changes of length over the length at zero strain, compression "
                                  "positive; shear angles."),
                   "Strains at the end.")
           .or_empty(),
       key::object(
           "stress",
           component_keys("stress", "Pa",
                          "Total Cauchy stresses, compression positive; the effective stress is "
                          "the total stress less the pore pressure."),
           "Stresses at the end.")
           .or_empty(),
       key::number("mean_stress", "Pa", "Mean of the total normal stresses at the end.").or_none(),
       key::texts("moved_by",
                  "Normal components whose total stresses change by the same amount to give "
                  "`mean_stress`.")
           .among(normal_names)
           .with("mean_stress"),
       key::choice("drainage", {"drained", "undrained"},
                   "`drained`: the pore pressure goes to `back_pressure`; `undrained`: the water "
                   "stays, compressible with `water`, else the volume is kept.")
           .or_else("drained"),
       key::integer("increments", "Number of rows of the table.")
           .in(between(1, 1000000))
           .or_else(100),
       key::number("duration", "s", "Time that the stage takes.")
           .in(positive())
           .or_none()
           .only("required where the law depends on time"),
       key::number("ocr", "",
                   "Over-consolidation ratio at the end of the stage. The clay then has the memory "
                   "that `initial_stress` of a run gives it under this stress, whatever came "
                   "before: preconsolidation and shear modulus. Other laws have none; then 1.")
           .in(at_least(1))
           .or_none()}};
}

KeyTable tested_body_keys() {
  return {"body",
          "",
          {key::plain_name(""), key::object("material", material_keys(material_laws), ""),
           key::object("water", mpm::pore_water_keys(), "").or_none()}};
}

KeyTable scene_keys() {
  return {"mpm", "", {key::objects("bodies", tested_body_keys(), "")}};
}

Components read_components(ConfigReader in) {
  Components found;
  for (int k = 0; k < num_components; ++k) found[k] = in.optional_number(component_names[k]);
  in.finish();
  return found;
}

// Refuse a component that two quantities lead.
void require_once(const ConfigReader& in, const StageSettings& stage) {
  for (int k = 0; k < num_components; ++k) {
    const bool moved = std::ranges::find(stage.moved, k) != stage.moved.end();
    if (int(stage.strain[k].has_value()) + int(stage.stress[k].has_value()) + int(moved) < 2)
      continue;
    in.fail(moved ? "moved_by" : "stress/" + component_names[k],
            fmt::format("found \"{}\" prescribed twice, allowed: one of strain, stress and "
                        "moved_by",
                        component_names[k]));
  }
}

void read_mean_stress(ConfigReader& in, StageSettings& stage) {
  stage.mean_stress = in.optional_number("mean_stress");
  if (!stage.mean_stress) {
    if (in.has("moved_by")) in.fail("moved_by", "allowed only with \"mean_stress\"");
    return;
  }
  for (const std::string& word : in.texts("moved_by")) {
    const auto found = std::ranges::find(normal_names, word);
    if (found == normal_names.end()) {
      in.fail("moved_by",
              fmt::format("found \"{}\", allowed: {}", word, fmt::join(normal_names, ", ")));
    }
    stage.moved.push_back(static_cast<int>(found - normal_names.begin()));
  }
  std::ranges::sort(stage.moved);
  if (stage.moved.empty() || std::ranges::adjacent_find(stage.moved) != stage.moved.end()) {
    in.fail("moved_by",
            "found an empty list or a component twice, allowed: one to three of xx, yy, zz");
  }
}

StageSettings read_stage(ConfigReader& in, const ElementSettings& test) {
  StageSettings stage;
  stage.name = in.name("name");
  stage.zero_strain = in.boolean("zero_strain");
  stage.strain = read_components(in.object("strain"));
  stage.stress = read_components(in.object("stress"));
  read_mean_stress(in, stage);
  require_once(in, stage);
  stage.undrained = in.choice("drainage") == "undrained";
  stage.increments = in.integer("increments");
  stage.duration = in.optional_number("duration");
  stage.ocr = in.optional_number("ocr");
  if (stage.ocr.value_or(1) != 1 && !std::holds_alternative<CamClay<3>>(test.material.law)) {
    in.fail("ocr", fmt::format("found {} with the law {}, which does not remember its "
                               "consolidation, allowed: 1, or the law cam_clay",
                               *stage.ocr, test.material.law_name));
  }
  const bool led_by_stress =
      stage.mean_stress || std::ranges::any_of(stage.stress, &std::optional<double>::has_value);
  if (stage.undrained && !test.water && !led_by_stress) {
    in.fail("drainage",
            "found \"undrained\" without a stress: soil that keeps its volume has a pore pressure "
            "only where a total stress is known, allowed: one of \"stress\", or \"water\"");
  }
  in.finish();
  return stage;
}

// The material and the water of one object that has both keys.
// @param folder  of the file
void read_soil(const std::string& folder, ConfigReader& in, ElementSettings& test) {
  test.material = read_material_in<3>(folder, in.object("material"));
  if (auto water = in.optional_object("water")) {
    test.water =
        mpm::read_pore_water(std::move(*water), test.material.density, test.p_wave_modulus());
  }
}

void read_body(const TestedBody& tested, ElementSettings& test) {
  ConfigReader in = tested.scene.reader("mpm.json", scene_keys());
  std::vector<std::string> names;
  auto bodies = in.objects("bodies");
  for (auto& body : bodies) {
    names.push_back(body.name("name"));
    if (tested.name.empty() ? bodies.size() != 1 : names.back() != tested.name) continue;
    read_soil(tested.scene.folder(), body, test);
    return;
  }
  in.fail("bodies",
          fmt::format("found {}, allowed: --body NAME with one of these", fmt::join(names, ", ")));
}

// Whether the stress may depend on how long a step takes. A law with a context that it needs for
// something else can say so: `static constexpr bool depends_on_time = false`.
template <class Law>
bool depends_on_time(const Law& law) {
  if constexpr (requires { Law::depends_on_time; }) {
    return Law::depends_on_time;
  } else if constexpr (requires { law.parameters().relaxation_time; }) {
    return law.parameters().relaxation_time > 0;
  } else {
    return ContextualLaw<Law, 3>;
  }
}

// Check that the settings have the time and the width of a shear band where the law needs them.
void require_context(const ConfigReader& in, const ElementSettings& test) {
  const auto& law = test.material.law;
  const bool by_slip = std::visit(
      [](const auto& model) {
        if constexpr (requires { model.parameters().by_slip; }) return model.parameters().by_slip;
        return false;
      },
      law);
  if (by_slip && !in.has("band_width")) {
    in.fail("band_width",
            "found none with a strength that depends on slip, allowed: a number > 0, the height "
            "over which the sample shears; in a run about a cell of the grid");
  }
  if (!std::visit([](const auto& model) { return depends_on_time(model); }, law)) return;
  for (std::size_t k = 0; k < test.stages.size(); ++k) {
    if (test.stages[k].duration) continue;
    in.fail(fmt::format("stages/{}/duration", k),
            fmt::format("found none with the law {}, whose stress may depend on time, allowed: a "
                        "number > 0",
                        test.material.law_name));
  }
}

}  // namespace

KeyTable element_keys() {
  return {"element",
          "Settings of an element test.",
          {key::schema(),
           key::object("material", material_keys(material_laws),
                       "Law and constants, as in mpm.json; none: those of a body of --scene.")
               .or_none(),
           key::object("water", mpm::pore_water_keys(),
                       "Pore water, as in mpm.json; none: undrained soil keeps its volume.")
               .or_none()
               .with("material"),
           key::number("band_width", "m",
                       "Height over which the sample shears, for strength that depends on slip.")
               .in(positive())
               .or_none(),
           key::number("back_pressure", "Pa", "Pore pressure at the start and while it drains.")
               .in(non_negative())
               .or_else(0),
           key::choice("rotation", {"none", "simple_shear"},
                       "`none`: the sample does not rotate; `simple_shear`: planes normal to the "
                       "second axis of a shear keep their direction.")
               .or_else("none"),
           key::objects("stages", stage_keys(), "Parts of the test, one after the other.")
               .not_empty()}};
}

ElementSettings read_element_settings(ConfigReader& in, const TestedBody* body) {
  ElementSettings test;
  if (in.has("$schema")) in.text("$schema");
  if (body != nullptr) {
    if (in.has("material")) in.fail("material", "found one beside --scene, allowed: one of both");
    read_body(*body, test);
  } else if (!in.has("material")) {
    in.fail("material", "found none, allowed: a material, or --scene SCENE with one");
  } else {
    read_soil(std::filesystem::path(in.file()).parent_path().string(), in, test);
  }
  test.band_width = in.optional_number("band_width").value_or(0);
  test.back_pressure = in.number("back_pressure");
  test.simple_shear = in.choice("rotation") == "simple_shear";
  auto stages = in.objects("stages");
  if (stages.empty()) in.fail("stages", "found an empty list, allowed: at least one stage");
  for (auto& stage : stages) test.stages.push_back(read_stage(stage, test));
  require_context(in, test);
  in.finish();
  return test;
}

}  // namespace gabion::element
