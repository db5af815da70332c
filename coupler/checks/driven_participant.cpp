// SPDX-License-Identifier: BSD-3-Clause
#include "coupler/checks/driven_participant.hpp"

#include "common/base/error.hpp"
#include "common/run/facets.hpp"
#include "common/run/start.hpp"

namespace gabion {

void DrivenParticipant::tell_force_kinds() {
  if (!solver_.takes_force_kinds()) return;
  ForceKinds kinds;
  for (const InterfaceMesh& mesh : meshes_) kinds[mesh.name] = ForceKind::step_mean;
  solver_.set_force_kinds(kinds);
}

void DrivenParticipant::tell_start() {
  InterfaceValues start;
  for (const InterfaceMesh& mesh : meshes_) start[mesh.name].assign(mesh.coordinates.size(), 0.0);
  set_start(solver_, start);
}

void DrivenParticipant::tell_facets() {
  InterfaceFacets facets;
  for (const InterfaceMesh& mesh : meshes_) {
    if (mesh.vertices_per_facet > 0) facets[mesh.name] = mesh.facets;
  }
  set_facets(solver_, facets);
}

std::vector<double> DrivenParticipant::vertices_of_facets() const {
  std::vector<double> vertices;
  for (const auto& [name, facets] : changing_facets(solver_)) {
    vertices.push_back(static_cast<double>(facets.size()));
    vertices.insert(vertices.end(), facets.begin(), facets.end());
  }
  return vertices;
}

InterfaceValues DrivenParticipant::random_values() {
  InterfaceValues values;
  std::uniform_real_distribution<double> spread(-settings_.amplitude, settings_.amplitude);
  for (const InterfaceMesh& mesh : meshes_) {
    std::vector<double>& list = values[mesh.name];
    for (std::size_t i = 0; i < mesh.coordinates.size(); ++i) list.push_back(spread(random_));
  }
  return values;
}

InterfaceValues DrivenParticipant::solve(const InterfaceValues& values, double part) {
  InterfaceValues answer;
  last_report_ = solver_.solve_step(request(part), values, answer);
  return answer;
}

AnswerDifference DrivenParticipant::again(const InterfaceValues& values,
                                          const InterfaceValues& before, double part) {
  AnswerDifference difference;
  compare(before, solve(values, part), difference);
  return difference;
}

void DrivenParticipant::compare(const InterfaceValues& before, const InterfaceValues& now,
                                AnswerDifference& difference) const {
  for (const InterfaceMesh& mesh : meshes_) {
    difference.add(mesh.name, mesh.dim, before.at(mesh.name), now.at(mesh.name));
  }
}

void DrivenParticipant::accept(double part) {
  const StepRequest accepted = request(part);
  const AcceptReport report = solver_.accept_step(accepted, true);
  at_rest_ = report.at_rest;
  note_details(last_report_.details, report.details);
  end_step(accepted);
}

void DrivenParticipant::skip_step() {
  const StepRequest skipped = request(1);
  solver_.accept_step(skipped, false);
  end_step(skipped);
}

void DrivenParticipant::end_step(const StepRequest& done) {
  time_ += done.dt;
  ++step_;
}

void DrivenParticipant::load(const State& state, const Place& place) {
  solver_.load_state(state);
  tell_force_kinds();
  step_ = place.step;
  time_ = place.time;
}

/// Checks the details of both reports as a run does that writes them into its table of steps.
void DrivenParticipant::note_details(const Json& of_solution, const Json& of_acceptance) {
  Json details = Json::object();
  for (const Json* report : {&of_solution, &of_acceptance}) {
    for (const auto& item : report->items()) details[item.key()] = item.value();
  }
  if (!details_.started()) details_.start(details);
  try {
    std::vector<CsvValue> cells;
    details_.append(details, cells);
  } catch (const Error& problem) {
    if (details_problem_.empty()) details_problem_ = problem.what();
  }
}

}  // namespace gabion
