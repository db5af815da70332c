// SPDX-License-Identifier: BSD-3-Clause
#include "fem_solver/materials/line_material.hpp"

#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <utility>

#include "common/base/log.hpp"
#include "common/mechanics/materials/yield_tolerance.hpp"
#include "fem_solver/materials/read_hardening.hpp"

namespace gabion::fem {

const std::vector<std::string> line_laws = {"truss", "cable", "brake", "bar", "beam"};

LineResponse respond(const LineMaterial& material, double stress_free_length, double length,
                     double run) {
  const double k = material.stiffness() / stress_free_length;
  const double stretch = length - stress_free_length;
  LineResponse response{.force = 0, .slope = k, .energy = 0, .run = run};
  if (material.brake) {
    const Brake::Balance balance = material.brake->balance(stretch, run, k);
    response.run = balance.run;
    response.slope = balance.slope;
  }
  const double elastic = stretch - response.run;
  if (elastic <= 0 && !material.in_compression) {
    response.slope = 0;
    return response;
  }
  response.force = k * elastic;
  response.energy = 0.5 * k * elastic * elastic;
  return response;
}

BarStress bar_stress(const LineMaterial& bar, double strain, std::span<const double> history_n,
                     std::span<double> history) {
  const double E = bar.young_modulus, H_k = bar.kinematic_modulus;
  double plastic = history_n[0], p = history_n[1], tangent = E;
  const double excess = E * (strain - plastic) - H_k * plastic;
  const double yield_stress = bar.hardening->yield_stress(p);
  const double size = E * (std::abs(strain) + std::abs(plastic));
  if (std::abs(excess) - yield_stress > yield_tolerance * (size + yield_stress)) {
    const PlasticFlow flow = bar.hardening->flow(std::abs(excess), p, E + H_k);
    plastic += std::copysign(flow.strain, excess);
    p += flow.strain;
    tangent = E * (1 - E / (E + H_k + flow.slope));
  }
  history[0] = plastic;
  history[1] = p;
  return {.stress = E * (strain - plastic), .slope = tangent, .elastic_strain = strain - plastic};
}

namespace {

LineResponse respond_of_bar(const LineMaterial& bar, double stress_free_length, double length,
                            std::span<const double> history_n, std::span<double> history) {
  const double strain = (length - stress_free_length) / stress_free_length;
  const BarStress point = bar_stress(bar, strain, history_n, history);
  return {.force = bar.area * point.stress,
          .slope = bar.area * point.slope / stress_free_length,
          .energy = 0.5 * bar.area * stress_free_length * point.stress * point.elastic_strain,
          .run = 0};
}

}  // namespace

LineResponse respond(const LineMaterial& material, double stress_free_length, double length,
                     std::span<const double> history_n, std::span<double> history) {
  if (material.hardening) {
    return respond_of_bar(material, stress_free_length, length, history_n, history);
  }
  const double run = material.brake ? history_n[0] : 0;
  const LineResponse response = respond(material, stress_free_length, length, run);
  if (material.brake) history[0] = response.run;
  return response;
}

double plastic_work(const LineMaterial& bar, std::span<const double> history) {
  return bar.hardening->work(history[1]) + 0.5 * bar.kinematic_modulus * history[0] * history[0];
}

std::vector<Key> line_keys() {
  const std::vector<std::string> brake = {"brake"}, along = {"truss", "cable", "brake", "bar"};
  return {
      key::number("area", "m^2",
                  "Cross-section of a line without stress; in 2D per metre of thickness [m].")
          .in(positive())
          .when("law", along),
      key::number("pretension", "N",
                  "Force in each line at its length in the mesh; either this or "
                  "`length_ratio`.")
          .in(non_negative())
          .or_none()
          .when("law", along),
      key::number("length_ratio", "",
                  "Length without stress over the length in the mesh: below 1 tensioned, "
                  "above 1 slack.")
          .in(positive())
          .or_none()
          .when("law", along),
      key::boolean("embedded",
                   "Whether nodes of these lines that are not nodes of cells lie inside cells "
                   "and move with them, without slip, at their place in the mesh.")
          .or_else(false)
          .when("law", along),
      key::rows("brake_table", "m, N",
                "Rows [run, force] of a brake in series with each cell of the group, the first "
                "at run 0. The brake runs out when the rope pulls with this force, and never "
                "back; linear between rows, constant after.")
          .wide(2, 2)
          .not_empty()
          .when("law", brake),
      key::number("run_limit", "m", "Run at which the brake stops for good; none: it never does.")
          .in(positive())
          .or_none()
          .when("law", brake)};
}

namespace {

Brake read_brake(ConfigReader& in) {
  std::vector<double> runs, forces;
  const auto rows = in.rows("brake_table", 2);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const double run = rows[i][0], force = rows[i][1];
    const std::string row = fmt::format("brake_table/{}", i);
    if (!(force > 0)) in.fail(row, fmt::format("found force {}, allowed: > 0", force));
    if (i == 0 && run != 0) {
      in.fail(row, fmt::format("found run {}, allowed: 0 in the first row", run));
    }
    if (i > 0 && !(run > runs.back())) {
      in.fail(row, fmt::format("found run {} after {}, allowed: rising runs", run, runs.back()));
    }
    runs.push_back(run);
    forces.push_back(force);
  }
  const double limit =
      in.has("run_limit") ? in.number("run_limit") : std::numeric_limits<double>::infinity();
  return {std::move(runs), std::move(forces), limit};
}

double read_length_ratio(ConfigReader& in, double stiffness) {
  if (in.has("pretension") && in.has("length_ratio")) {
    in.fail("length_ratio", "found beside \"pretension\", allowed: one of them");
  }
  if (in.has("length_ratio")) return in.number("length_ratio");
  if (!in.has("pretension")) return 1;
  const double strain = in.number("pretension") / stiffness;
  if (strain > 0.1) {
    log::warn("{}: strains the lines by {:.3g}; units?", in.where("pretension"), strain);
  }
  return 1 / (1 + strain);
}

// Refuse a strain at the start that makes a bar yield: its plastic work would be unknown.
void check_elastic_start(const ConfigReader& in, const LineMaterial& bar) {
  const double limit = bar.hardening->yield_stress(0);
  const double stress = bar.young_modulus * (1 / bar.length_ratio - 1);
  if (std::abs(stress) <= limit) return;
  in.fail(in.has("pretension") ? "pretension" : "length_ratio",
          fmt::format("found a stress of {:.6g} Pa at the start, allowed: up to the first yield "
                      "stress, {:.6g} Pa",
                      stress, limit));
}

/// Keys of a beam that yields, if it does.
void read_yielding_beam(ConfigReader& in, LineMaterial& beam) {
  const bool yields = in.has("yield_stress") || in.has("yield_table");
  for (const char* key : {"hardening_modulus", "kinematic_modulus"}) {
    if (yields || in.number(key) == 0) continue;
    in.fail(key, "found without \"yield_stress\" or \"yield_table\", allowed: with one of them");
  }
  if (!yields) return;
  if (beam.beam->section.fibres.empty()) {
    in.fail(in.has("yield_stress") ? "yield_stress" : "yield_table",
            "found with a section \"general\", allowed: sections with a shape, whose fibres yield");
  }
  beam.hardening = read_hardening(in);
  beam.kinematic_modulus = in.number("kinematic_modulus");
  check_yield(in, *beam.hardening, beam.young_modulus, beam.kinematic_modulus);
}

}  // namespace

LineMaterial read_line_material(ConfigReader in, int dim) {
  LineMaterial material;
  material.where = in.where("group");
  material.group = in.text("group");
  material.law_name = in.choice("law");
  material.density = in.number("density");
  material.young_modulus = in.number("young_modulus");
  if (material.law_name == "beam") {
    material.beam = read_beam(in, material.young_modulus, dim);
    material.area = material.beam->section.area;
    material.in_compression = true;
    read_yielding_beam(in, material);
    material.failure = read_failure(in, material.law_name);
    if (material.failure.plastic_strain && !material.hardening) {
      in.fail("failure_plastic_strain",
              "found with a beam that does not yield, allowed: with \"yield_stress\" or "
              "\"yield_table\"");
    }
    in.finish();
    return material;
  }
  material.area = in.number("area");
  material.length_ratio = read_length_ratio(in, material.stiffness());
  material.embedded = in.boolean("embedded");
  material.in_compression = material.law_name == "truss" || material.law_name == "bar";
  if (material.law_name == "bar") {
    material.hardening = read_hardening(in);
    material.kinematic_modulus = in.number("kinematic_modulus");
    check_yield(in, *material.hardening, material.young_modulus, material.kinematic_modulus);
    check_elastic_start(in, material);
  }
  if (material.law_name == "brake") {
    material.brake = read_brake(in);
    if (in.has("pretension") && in.number("pretension") > material.brake->force(0)) {
      in.fail("pretension", fmt::format("found {}, allowed: at most the first force of "
                                        "\"brake_table\", {}",
                                        in.number("pretension"), material.brake->force(0)));
    }
  }
  material.failure = read_failure(in, material.law_name);
  in.finish();
  return material;
}

}  // namespace gabion::fem
