// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Dense>
#include <functional>
#include <string>
#include <vector>

#include "common/mechanics/time_integration/newmark.hpp"
#include "common/run/solver.hpp"

namespace gabion::test {

/// Vertices on the line x = 0, y in [0, 1]; the structure lies to the right of it.
inline InterfaceMesh vertical_wall(int num_vertices) {
  InterfaceMesh mesh;
  mesh.name = "wall";
  mesh.dim = 2;
  mesh.vertices_per_facet = 2;
  for (int i = 0; i < num_vertices; ++i) {
    mesh.coordinates.insert(mesh.coordinates.end(), {0, 1 - double(i) / (num_vertices - 1)});
    if (i > 0) mesh.facets.insert(mesh.facets.end(), {i, i - 1});
  }
  return mesh;
}

/// A mass and a spring at every component of every vertex, Newmark's trapezoidal rule.
class MassSprings : public Solver {
 public:
  MassSprings(int num_vertices, double mass, double stiffness)
      : mesh_(vertical_wall(num_vertices)),
        mass_(mass),
        stiffness_(stiffness),
        u_(Eigen::VectorXd::Zero(2 * num_vertices)),
        v_(u_),
        a_(u_),
        load_(u_) {}

  std::vector<InterfaceMesh> interfaces() const override { return {mesh_}; }
  std::vector<std::string> probe_names() const override { return {"u", "energy"}; }
  std::vector<double> probes() const override { return {u_(0), energy()}; }
  void reject_step() override { ++rejected; }
  void write_output(double time) override { written.push_back(time); }
  Json summary() const override { return {{"linear_solver", "none"}}; }
  AcceptReport accept_step(const StepRequest&, bool solved) override {
    if (!solved) {
      ++slept;
      return {probes(), true, 0};
    }
    u_ = u_trial_;
    v_ = v_trial_;
    a_ = a_trial_;
    ++accepted;
    return {probes(),
            v_.isZero(0) && a_.isZero(0),
            propose ? propose(accepted) : 0,
            {{"accepted_steps", accepted}}};
  }

  void rename_interface(const std::string& name) { mesh_.name = name; }
  void force_kind(ForceKind kind) { mesh_.force_kind = kind; }

  std::function<void(const StepRequest&)> on_solve;  // may throw
  std::function<double(int)> propose;                // dt [s] after so many accepted steps
  int accepted = 0;
  int slept = 0;
  int rejected = 0;
  int solves = 0;
  std::vector<double> written;
  double scatter = 1;  // masses and springs of vertex i are larger by 1 + scatter i / n

 protected:
  double factor(Eigen::Index i) const { return 1 + scatter * double(i / 2) / double(u_.size()); }
  /// Kinetic and elastic [J].
  double energy() const {
    double sum = 0;
    for (Eigen::Index i = 0; i < u_.size(); ++i) {
      sum += 0.5 * factor(i) * (mass_ * v_(i) * v_(i) + stiffness_ * u_(i) * u_(i));
    }
    return sum;
  }
  void set_trial(const Eigen::VectorXd& u, double dt) {
    const NewmarkBossak newmark;
    u_trial_ = u;
    a_trial_ = v_trial_ = u;
    for (Eigen::Index i = 0; i < u.size(); ++i) {
      a_trial_(i) = newmark.acceleration(u(i) - u_(i), v_(i), a_(i), dt);
      v_trial_(i) = newmark.velocity(a_trial_(i), v_(i), a_(i), dt);
    }
  }
  StepReport start(const StepRequest& request) {
    ++solves;
    if (on_solve) on_solve(request);
    StepReport report;
    report.newton_iterations = 2;
    report.linear_iterations = 7;
    report.details = {{"work", 1.5 * double(request.step)}};
    return report;
  }

  InterfaceMesh mesh_;
  double mass_;
  double stiffness_;
  Eigen::VectorXd u_, v_, a_, u_trial_, v_trial_, a_trial_, load_;
};

/// Displacement in, force out: what is left of the load when mass and spring took their share.
class SoilSprings : public MassSprings {
 public:
  using MassSprings::MassSprings;
  /// Load on all x components at a time; contact is possible while it is not zero, or when `near`.
  std::function<double(double)> load = [](double) { return 0; };
  bool near = false;
  bool pretend_inactive = false;

  StepReport solve_step(const StepRequest& request, const InterfaceValues& received,
                        InterfaceValues& sent) override {
    StepReport report = start(request);
    const double t = request.time + request.dt;
    Eigen::VectorXd force = Eigen::VectorXd::Zero(u_.size());
    report.interface_active = near || load(t) != 0;
    if (report.interface_active) {
      set_trial(Eigen::Map<const Eigen::VectorXd>(received.at(mesh_.name).data(), u_.size()),
                request.dt);
      for (Eigen::Index i = 0; i < u_.size(); ++i) {
        const double push = i % 2 == 0 ? load(t) : 0.5 * load(t);
        force(i) = push - factor(i) * (mass_ * a_trial_(i) + stiffness_ * u_trial_(i));
      }
    } else {
      u_trial_ = u_;
      v_trial_ = v_;
      a_trial_ = a_;
    }
    if (pretend_inactive) report.interface_active = false;
    sent[mesh_.name].assign(force.begin(), force.end());
    return report;
  }
};

/// Force in, displacement out.
class StructureSprings : public MassSprings {
 public:
  using MassSprings::MassSprings;

  StepReport solve_step(const StepRequest& request, const InterfaceValues& received,
                        InterfaceValues& sent) override {
    const StepReport report = start(request);
    const NewmarkBossak newmark;
    const double slope = newmark.inertia_slope(request.dt);
    Eigen::VectorXd u = u_;
    for (Eigen::Index i = 0; i < u.size(); ++i) {
      const double a0 = newmark.acceleration(-u_(i), v_(i), a_(i), request.dt);  // at u = 0
      u(i) = (received.at(mesh_.name)[i] - factor(i) * mass_ * a0) /
             (factor(i) * (mass_ * slope + stiffness_));
    }
    set_trial(u, request.dt);
    sent[mesh_.name].assign(u.begin(), u.end());
    return report;
  }
};

}  // namespace gabion::test
