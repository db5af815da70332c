// SPDX-License-Identifier: BSD-3-Clause
#include "coupler/acceleration/quasi_newton.hpp"

namespace gabion {

void QuasiNewton::begin_step() {
  current_.clear();
  r_last_.resize(0);
  x_tilde_last_.resize(0);
}

void QuasiNewton::reset() {
  begin_step();
  forget();
}

void QuasiNewton::add_pair(const Eigen::VectorXd& x, const Eigen::VectorXd& x_tilde) {
  const Eigen::VectorXd r = x_tilde - x;
  if (r_last_.size() > 0) {
    current_.insert(current_.begin(), Secant{r - r_last_, x_tilde - x_tilde_last_});
    if (static_cast<int>(current_.size()) > settings_.max_columns) current_.pop_back();
  }
  r_last_ = r;
  x_tilde_last_ = x_tilde;
}

Eigen::VectorXd QuasiNewton::next(const Eigen::VectorXd& x, const Eigen::VectorXd& x_tilde) {
  add_pair(x, x_tilde);
  counters_ = {};
  Eigen::VectorXd r = r_last_;
  Eigen::VectorXd update = Eigen::VectorXd::Zero(r.size());
  apply(current_, r, update);
  if (counters_.columns == 0) {
    counters_.omega = settings_.relaxation;
    return x + settings_.relaxation * r_last_;
  }
  return x + update + settings_.damping * r;
}

void QuasiNewton::end_step(const Eigen::VectorXd& x, const Eigen::VectorXd& x_tilde) {
  add_pair(x, x_tilde);
  if (!current_.empty() && settings_.history > 0) remember(current_);
  begin_step();
}

void IqnIls::apply(const std::vector<Secant>& current, Eigen::VectorXd& r,
                   Eigen::VectorXd& update) {
  std::vector<Secant> all = current;
  for (const auto& step : earlier_) all.insert(all.end(), step.begin(), step.end());
  const auto most = static_cast<std::size_t>(settings_.max_columns);
  if (all.size() > most) all.erase(all.begin() + settings_.max_columns, all.end());
  const SecantBlock block(all, settings_.filter);
  counters_.columns = block.num_columns();
  counters_.columns_dropped = block.num_dropped();
  block.apply(r, update);
}

void IqnIls::remember(const std::vector<Secant>& current) {
  earlier_.push_front(current);
  if (static_cast<int>(earlier_.size()) > settings_.history) earlier_.pop_back();
}

void Mvqn::apply(const std::vector<Secant>& current, Eigen::VectorXd& r, Eigen::VectorXd& update) {
  const SecantBlock block(current, settings_.filter);
  counters_.columns = block.num_columns();
  counters_.columns_dropped = block.num_dropped();
  block.apply(r, update);
  for (const SecantBlock& step : earlier_) {
    counters_.columns += step.num_columns();
    counters_.columns_dropped += step.num_dropped();
    step.apply(r, update);
  }
}

void Mvqn::remember(const std::vector<Secant>& current) {
  earlier_.emplace_front(current, settings_.filter);
  int columns = 0;
  for (const SecantBlock& step : earlier_) columns += step.num_columns();
  while (static_cast<int>(earlier_.size()) > settings_.history ||
         (columns > settings_.max_columns && earlier_.size() > 1)) {
    columns -= earlier_.back().num_columns();
    earlier_.pop_back();
  }
}

}  // namespace gabion
