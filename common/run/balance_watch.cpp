// SPDX-License-Identifier: BSD-3-Clause
#include "common/run/balance_watch.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "common/base/log.hpp"

namespace gabion {

namespace {

// Where the work on a structure goes, as the columns of its tables name it.
constexpr std::array stored_or_dissipated = {"kinetic_energy", "elastic_energy", "plastic_work",
                                             "damage_work",    "brake_work",     "failed_energy",
                                             "damping_work"};

// What most often gives a structure more kinetic energy than ever came in.
constexpr auto ringing =
    "; waves that are shorter than the step ring in it: \"time_integration\" of \"scheme\" "
    "\"generalized_alpha\" with \"rho_inf\" 0 damps them, smaller steps resolve them";

/// A balance is not closed from this share of what was exchanged on; scripts/plotting/verdict.py
/// has the same limit.
constexpr double open_share = 1e-2;

constexpr double round_off = 1e-9;

// Cuts of the step size are normal; from this number on they deserve a warning.
constexpr int many_cuts = 10;
constexpr double often = 0.1;  // share of the steps

/// The participant's name, in quotes, of the prefix "soil."; without coupler a word for it.
std::string name_of(const std::string& owner, const char* alone) {
  return owner.empty() ? alone : fmt::format("\"{}\"", owner.substr(0, owner.size() - 1));
}

double percent(double share) {
  return 100 * share;
}

}  // namespace

void BalanceWatch::start(const std::vector<std::string>& probe_names) {
  names_ = probe_names;
}

void BalanceWatch::add(std::span<const double> probes) {
  for (std::size_t k = 0; k < std::min(probes.size(), names_.size()); ++k) {
    Column& column = columns_[names_[k]];
    if (rows_ == 0) column.first = column.lowest = probes[k];
    column.last = probes[k];
    column.lowest = std::min(column.lowest, probes[k]);
    column.largest = std::max(column.largest, std::abs(probes[k]));
  }
  ++rows_;
}

void BalanceWatch::add_work(double soil_work, double made) {
  soil_work_ += soil_work;
  most_soil_work_ = std::max(most_soil_work_, std::abs(soil_work_));
  made_work_ += made;
}

const BalanceWatch::Column& BalanceWatch::column(const std::string& owner,
                                                 const std::string& name) const {
  static const Column none;
  const auto found = columns_.find(owner + name);
  return found == columns_.end() ? none : found->second;
}

double BalanceWatch::largest(const std::string& owner,
                             std::initializer_list<const char*> names) const {
  double result = 0;
  for (const char* name : names) result = std::max(result, column(owner, name).largest);
  return result;
}

/// Prefixes of the columns with this name: "soil.", or "" in a run without coupler.
std::vector<std::string> BalanceWatch::owners(const std::string& name) const {
  std::vector<std::string> result;
  for (const auto& [full, values] : columns_) {
    if (full == name || full.ends_with("." + name)) {
      result.push_back(full.substr(0, full.size() - name.size()));
    }
  }
  return result;
}

void BalanceWatch::judge_soil(const std::string& owner, std::vector<std::string>& faults) const {
  const std::string name = name_of(owner, "the soil");
  const double around =
      largest(owner, {"gravity_work", "boundary_work", "kinetic_energy", "elastic_energy"});
  if (around > 0) {
    const double error = largest(owner, {"energy_balance"}) / around;
    const double made = largest(owner, {"created_energy", "contact_created"}) / around;
    if (std::max(error, made) >= open_share) {
      faults.push_back(
          fmt::format("energy balance of {} is not closed: of the {:.3g} J that were exchanged, "
                      "{:.2g} % are missing and {:.2g} % were created",
                      name, around, percent(error), percent(made)));
    }
  }
  // Soil at rest has next to no momentum, and rounding of its weight's impulse is not a fault.
  const double moved = std::max(largest(owner, {"momentum_x", "momentum_y", "momentum_z"}),
                                std::sqrt(2 * largest(owner, {"mass"}) * around));
  const double error = largest(owner, {"momentum_error_x", "momentum_error_y", "momentum_error_z"});
  if (moved > 0 && error >= open_share * moved) {
    faults.push_back(fmt::format(
        "momentum balance of {} is not closed: {:.2g} % of {:.3g} kg m/s are missing (of the "
        "largest momentum, or of sqrt(2 m E) of the energy exchanged)",
        name, percent(error / moved), moved));
  }
}

void BalanceWatch::judge_structure(const std::string& owner,
                                   std::vector<std::string>& faults) const {
  const std::string name = name_of(owner, "the structure");
  const double at_start =
      column(owner, "kinetic_energy").first + column(owner, "elastic_energy").first;
  const double around = std::max(at_start, largest(owner, {"external_work"}));
  if (!(around > 0)) return;
  const auto change = [&](const char* of) {
    return column(owner, of).last - column(owner, of).first;
  };
  double kept = -change("external_work");
  for (const char* part : stored_or_dissipated) kept += change(part);
  const double gain = kept / around;
  if (gain >= open_share) {
    const bool rings = largest(owner, {"kinetic_energy"}) > around;
    faults.push_back(fmt::format("energy of {}: {:.2g} % more than the {:.3g} J that came in{}",
                                 name, percent(gain), around, rings ? ringing : ""));
  }
  const double damping = column(owner, "damping_work").lowest;
  if (damping < -round_off * around) {
    faults.push_back(fmt::format("damping of {} created {:.3g} J", name, -damping));
  }
}

std::vector<std::string> BalanceWatch::faults() const {
  std::vector<std::string> faults;
  for (const std::string& owner : owners("energy_balance")) judge_soil(owner, faults);
  for (const std::string& owner : owners("external_work")) judge_structure(owner, faults);
  if (most_soil_work_ > 0 && std::abs(made_work_) >= open_share * most_soil_work_) {
    faults.push_back(fmt::format("the coupling {} {:.3g} % of the work that it passed on",
                                 made_work_ > 0 ? "made" : "took",
                                 percent(std::abs(made_work_) / most_soil_work_)));
  }
  if (cuts_ >= many_cuts && static_cast<double>(cuts_) >= often * static_cast<double>(rows_)) {
    faults.push_back(fmt::format("{} cuts of the step size in {} steps", cuts_, rows_));
  }
  return faults;
}

void BalanceWatch::report() const {
  for (const std::string& fault : faults()) log::warn("{}", fault);
}

}  // namespace gabion
