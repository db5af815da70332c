// SPDX-License-Identifier: BSD-3-Clause
#include "coupler/acceleration/quasi_newton.hpp"

#include <algorithm>

#include "coupler/state_vectors.hpp"

namespace gabion {

namespace {

/// Coordinates of secants as columns; entries are 0 for vectors by which the basis has grown since
/// a secant came.
Eigen::MatrixXd matrix_of(const std::deque<Secant>& secants, const std::vector<std::size_t>& which,
                          Eigen::Index rows) {
  Eigen::MatrixXd result = Eigen::MatrixXd::Zero(rows, static_cast<Eigen::Index>(which.size()));
  for (std::size_t k = 0; k < which.size(); ++k) {
    const Eigen::VectorXd& s = secants[which[k]].s;
    result.col(static_cast<Eigen::Index>(k)).head(s.size()) = s;
  }
  return result;
}

}  // namespace

bool ProgressWatch::fails(const Eigen::VectorXd& x_tilde, const Eigen::VectorXd& r) {
  if (best_r_.size() == 0 || r.norm() < best_r_.norm()) {
    best_r_ = r;
    best_x_tilde_ = x_tilde;
    since_best_ = 0;
    return false;
  }
  return ++since_best_ >= patience || r.norm() > growth * best_r_.norm();
}

void ProgressWatch::begin_step() {
  best_r_.resize(0);
  best_x_tilde_.resize(0);
  since_best_ = 0;
}

void ProgressWatch::rescale(const Eigen::VectorXd& ratio) {
  if (best_r_.size() == 0) return;
  best_r_.array() *= ratio.array();
  best_x_tilde_.array() *= ratio.array();
}

void QuasiNewton::add_pair(const Eigen::VectorXd& x, const Eigen::VectorXd& x_tilde,
                           Eigen::VectorXd& t) {
  const Eigen::VectorXd r = x_tilde - x;
  const bool moved = r_last_.size() > 0 && r != r_last_;
  if (moved) {
    Secant secant;
    basis_.extend(r - r_last_, r, secant.s, t);
    secant.w = x_tilde - x_tilde_last_;
    secant.step = step_;
    secants_.push_front(std::move(secant));
  } else {
    t = basis_.coordinates(r);
  }
  r_last_ = r;
  x_tilde_last_ = x_tilde;
}

Eigen::VectorXd QuasiNewton::next(const Eigen::VectorXd& x, const Eigen::VectorXd& x_tilde) {
  counters_ = {};
  Eigen::VectorXd t;
  add_pair(x, x_tilde, t);
  if (watch_.fails(x_tilde, r_last_) && fall_back()) t = basis_.coordinates(r_last_);
  limit_columns();
  Eigen::VectorXd c;
  Eigen::VectorXd t_left = t;
  cover(t_left, c);
  counters_.columns = num_in_use();
  if (counters_.columns == 0) {
    counters_.omega = settings_.relaxation;
    return x + settings_.relaxation * r_last_;
  }
  Eigen::VectorXd result = x_tilde_last_;
  std::vector<const Eigen::VectorXd*> columns;
  std::vector<double> factors;
  for (std::size_t k = 0; k < secants_.size(); ++k) {
    if (secants_[k].dropped) continue;
    columns.push_back(&secants_[k].w);
    factors.push_back(c(static_cast<Eigen::Index>(k)));
  }
  add_combination(columns, factors, result);
  if (settings_.damping != 1) {
    Eigen::VectorXd left = r_last_;
    basis_.add(1, t_left - t, left);  // V c
    result -= (1 - settings_.damping) * left;
  }
  return counters_.fell_back ? result : shortened(x, result);
}

// Shorten the update: that of an exact Jacobian is no longer than the residual where the force that
// a displacement causes pushes against it, as between soil and structure.
Eigen::VectorXd QuasiNewton::shortened(const Eigen::VectorXd& x,
                                       const Eigen::VectorXd& next_x) const {
  constexpr double longest = 2;  // length of an update over that of the residual, at most
  const Eigen::VectorXd update = next_x - x;
  const double share = longest * r_last_.norm() / update.norm();
  return share < 1 ? Eigen::VectorXd(x + share * update) : next_x;
}

void QuasiNewton::cover(Eigen::VectorXd& t, Eigen::VectorXd& c) {
  std::vector<std::size_t> used;
  for (std::size_t k = 0; k < secants_.size(); ++k) {
    if (!secants_[k].dropped) used.push_back(k);
  }
  if (factored_) {
    const std::size_t num_new = secants_.size() - num_factored_;  // one at most
    factored_->keep_newest(static_cast<Eigen::Index>(used.size() - num_new));
    if (num_new > 0) factored_->prepend(secants_.front().s, filter_);
  } else {
    factored_.emplace(matrix_of(secants_, used, t.size()), filter_);
  }
  num_factored_ = secants_.size();
  const FilteredLeastSquares& problem = *factored_;
  const Eigen::VectorXd found = problem.solve(t);
  c.resize(static_cast<Eigen::Index>(secants_.size()));
  for (const std::size_t k : used) secants_[k].dropped = true;
  for (std::size_t i = 0; i < problem.kept().size(); ++i) {
    const std::size_t k = used[static_cast<std::size_t>(problem.kept()[i])];
    secants_[k].dropped = false;
    c(static_cast<Eigen::Index>(k)) = found(static_cast<Eigen::Index>(i));
  }
  counters_.dropped_by_filter = static_cast<int>(used.size() - problem.kept().size());
}

bool QuasiNewton::fall_back() {
  const Filter robust;
  if (filter_.kind == robust.kind && filter_.limit == robust.limit) return false;
  filter_ = robust;
  for (Secant& secant : secants_) secant.dropped = false;
  factored_.reset();
  // Secants stay as they are; the next one begins at the best pair.
  r_last_ = watch_.best_r();
  x_tilde_last_ = watch_.best_x_tilde();
  counters_.fell_back = true;
  return true;
}

void QuasiNewton::limit_columns() {
  int count = 0;
  for (Secant& secant : secants_) {
    if (secant.dropped || ++count <= settings_.max_columns) continue;
    secant.dropped = true;
    ++counters_.dropped_by_limit;
  }
}

int QuasiNewton::num_in_use() const {
  return static_cast<int>(std::count_if(secants_.begin(), secants_.end(),
                                        [](const Secant& secant) { return !secant.dropped; }));
}

void QuasiNewton::end_step(const Eigen::VectorXd& x, const Eigen::VectorXd& x_tilde) {
  Eigen::VectorXd t;
  add_pair(x, x_tilde, t);
  limit_columns();
  if (!secants_.empty() && secants_.front().step == step_) ++step_;
  forget_old_steps();
  factored_.reset();
  size_accepted_ = basis_.size();
  watch_.begin_step();
  r_last_.resize(0);
  x_tilde_last_.resize(0);
}

void QuasiNewton::forget_old_steps() {
  std::erase_if(secants_, [&](const Secant& secant) {
    return secant.dropped || secant.step < step_ - settings_.history;
  });
  if (basis_.size() <= static_cast<Eigen::Index>(secants_.size())) return;
  std::vector<std::size_t> all(secants_.size());
  for (std::size_t k = 0; k < all.size(); ++k) all[k] = k;
  Eigen::MatrixXd s = matrix_of(secants_, all, basis_.size());
  basis_.shrink(s);
  for (std::size_t k = 0; k < all.size(); ++k) secants_[k].s = s.col(static_cast<Eigen::Index>(k));
}

void QuasiNewton::discard_step() {
  std::erase_if(secants_, [&](const Secant& secant) { return secant.step == step_; });
  for (Secant& secant : secants_) secant.dropped = false;
  factored_.reset();
  basis_.truncate(size_accepted_);
  watch_.begin_step();
  r_last_.resize(0);
  x_tilde_last_.resize(0);
}

int QuasiNewton::reset() {
  const auto forgotten = static_cast<int>(secants_.size());
  secants_.clear();
  factored_.reset();
  basis_.truncate(0);
  size_accepted_ = 0;
  r_last_.resize(0);
  x_tilde_last_.resize(0);
  return forgotten;
}

void QuasiNewton::rescale(const Eigen::VectorXd& ratio) {
  factored_.reset();
  const Eigen::MatrixXd T = basis_.rescale(ratio);
  for (Secant& secant : secants_) {
    const Eigen::Index m = secant.s.size();
    secant.s = (T.topLeftCorner(m, m) * secant.s).eval();
    secant.w.array() *= ratio.array();
  }
  if (r_last_.size() == 0) return;
  r_last_.array() *= ratio.array();
  x_tilde_last_.array() *= ratio.array();
  watch_.rescale(ratio);
}

void QuasiNewton::visit_state(StateVisitor& visitor) {
  discard_step();
  int kind = static_cast<int>(filter_.kind);
  visitor.integer("secants.filter", kind);
  filter_.kind = static_cast<FilterKind>(kind);
  visitor.real("secants.filter_limit", filter_.limit);
  basis_.visit_state(visitor);
  visitor.integer("secants.step", step_);
  const auto resize = [&](std::size_t count) { secants_.resize(count); };
  visit_vectors(visitor, "secants.s", secants_.size(), resize,
                [&](std::size_t k) -> Eigen::VectorXd& { return secants_[k].s; });
  visit_vectors(visitor, "secants.w", secants_.size(), resize,
                [&](std::size_t k) -> Eigen::VectorXd& { return secants_[k].w; });
  std::vector<std::int64_t> steps;
  for (const Secant& secant : secants_) steps.push_back(secant.step);
  visitor.integers("secants.steps", steps);
  for (std::size_t k = 0; k < steps.size(); ++k) secants_[k].step = steps[k];
  size_accepted_ = basis_.size();
}

}  // namespace gabion
