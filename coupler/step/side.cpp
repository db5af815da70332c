// SPDX-License-Identifier: BSD-3-Clause
#include "coupler/step/side.hpp"

#include <utility>

namespace gabion {

/// Notes how long a call to the solver takes, whether it succeeds or not.
class Side::CallTimer {
 public:
  explicit CallTimer(Side& side) : side_(side) {}
  CallTimer(Side& side, const Stopwatch& since) : side_(side), watch_(since) {}
  ~CallTimer() {
    const double seconds = watch_.seconds();
    side_.call_seconds_ += seconds;
    side_.busy_seconds_ += side_.solver_.last_busy_seconds().value_or(seconds);
  }
  CallTimer(const CallTimer&) = delete;
  CallTimer& operator=(const CallTimer&) = delete;
  CallTimer(CallTimer&&) = delete;
  CallTimer& operator=(CallTimer&&) = delete;

 private:
  Side& side_;
  Stopwatch watch_;
};

void Side::begin_step() {
  call_seconds_ = 0;
  busy_seconds_ = 0;
  if (under_way_) under_way_->watch = Stopwatch();
}

void Side::start_solve(const StepRequest& request, const Eigen::VectorXd& given) {
  under_way_ = UnderWay{request, {}, Stopwatch()};
  if (AsynchronousSolver* solver = asynchronous()) {
    solver->start_solve(request, layout_.values_in(given));
  } else {
    under_way_->received = layout_.values_in(given);
  }
}

void Side::finish_solve(Eigen::VectorXd& answer) {
  const UnderWay task = *std::exchange(under_way_, std::nullopt);
  InterfaceValues sent;
  if (AsynchronousSolver* solver = asynchronous()) {
    const CallTimer timer(*this, task.watch);
    note_solution(solver->finish_solve(sent));
  } else {
    const CallTimer timer(*this);
    note_solution(solver_.solve_step(task.request, task.received, sent));
  }
  layout_.put(sent, answer);
}

void Side::note_solution(const StepReport& report) {
  report_ = report;
  solved_ = true;
  linear_iterations_ += report_.linear_iterations;
}

void Side::skip() {
  report_ = {};
  solved_ = false;
}

void Side::start_accept(const StepRequest& request) {
  accepting_ = request;
  if (AsynchronousSolver* solver = asynchronous()) solver->start_accept(request, solved_);
}

AcceptReport Side::finish_accept(const Eigen::VectorXd& given, const Stopwatch& since) {
  AcceptReport report;
  if (AsynchronousSolver* solver = asynchronous()) {
    const CallTimer timer(*this, since);
    report = solver->finish_accept();
  } else {
    const CallTimer timer(*this);
    report = solver_.accept_step(accepting_, solved_);
  }
  accepted_details_ = report.details;
  may_sleep_ = report.at_rest && layout_.is_zero_in(given);
  solves_next_ = under_way_ && under_way_->proposed.contains(report.proposed_dt);
  return report;
}

bool Side::takes_next_step() const {
  const AsynchronousSolver* solver = asynchronous();
  return solver != nullptr && solver->takes_next_step();
}

void Side::start_next(const StepRequest& request, const Eigen::VectorXd& given,
                      const DtRange& proposed) {
  under_way_ = UnderWay{request, {}, Stopwatch(), proposed};
  asynchronous()->start_next(request, layout_.values_in(given), proposed);
}

void Side::call_off_next() {
  const CallTimer timer(*this);
  under_way_.reset();
  asynchronous()->call_off_solve();
}

void Side::reject() {
  const CallTimer timer(*this);
  solver_.reject_step();
}

void Side::add_details(double wall_seconds, Json& details) const {
  const std::string prefix = name() + ".";
  for (const Json* report : {&report_.details, &accepted_details_}) {
    for (const auto& item : report->items()) details[prefix + item.key()] = item.value();
  }
  details[prefix + "linear_iterations"] = linear_iterations_;
  details[prefix + "busy_seconds"] = busy_seconds_;
  details[prefix + "message_seconds"] = call_seconds_ - busy_seconds_;
  details[prefix + "waiting_seconds"] = wall_seconds - call_seconds_;
}

Json Side::calls() const {
  const AsynchronousSolver* solver = asynchronous();
  if (solver == nullptr) return {};
  Json calls;
  for (const auto& [kind, times] : solver->call_times()) {
    calls[kind] = {
        {"count", times.count}, {"seconds", times.seconds}, {"busy_seconds", times.busy_seconds}};
  }
  return calls;
}

}  // namespace gabion
