// SPDX-License-Identifier: BSD-3-Clause
#include "common/mechanics/newton/newton.hpp"

#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "common/base/unbalanced.hpp"
#include "common/mechanics/newton/regularisation.hpp"
#include "common/mechanics/norm.hpp"

namespace gabion {

namespace {

constexpr int max_cuts = 8;
constexpr int max_supported_cuts = 40;  // parts that nothing held may come back from far away
constexpr double energy_reduction = 0.8;
constexpr double reuse_reduction = 0.25;  // |r| after by before, at most, with an old matrix
constexpr double loosest_linear_tolerance = 1e-2;
constexpr double linear_margin = 3e-1;

constexpr std::size_t longest_series = 20, shown_first = 4, shown_last = 12;

/// Residuals one after the other; of many the first and the last ones.
std::string series_text(std::span<const double> residuals) {
  if (residuals.size() <= longest_series) return fmt::format("{:.2e}", fmt::join(residuals, " "));
  return fmt::format("{:.2e} ({} more) {:.2e}", fmt::join(residuals.first(shown_first), " "),
                     residuals.size() - shown_first - shown_last,
                     fmt::join(residuals.last(shown_last), " "));
}

struct WorstNode {
  std::size_t node = 0;
  double size = 0;  // norm of its values
};

template <int block_size>
WorstNode worst_node(std::span<const double> values) {
  WorstNode worst;
  for (std::size_t i = 0; i * block_size < values.size(); ++i) {
    const double size = norm_of(values.subspan(i * block_size, block_size));
    if (size <= worst.size) continue;
    worst = {i, size};
    if (!std::isfinite(size)) break;
  }
  return worst;
}

/// State of one solve.
template <int block_size>
class Newton {
 public:
  Newton(NewtonProblem<block_size>& problem, NewtonMatrix<block_size>& matrix,
         const NewtonSettings& settings, std::span<double> du, PhaseTimes& times)
      : problem_(problem),
        matrix_(matrix),
        settings_(settings),
        du_(du),
        times_(times),
        r_(du.size()),
        step_(du.size()),
        trial_(du.size()),
        trial_r_(du.size()) {}

  NewtonReport run();

 private:
  struct Iterate {
    double norm = 0;      // |r|
    double relative = 0;  // |r| / force_scale
    bool small_residual = false;
    bool has_matrix = false;  // K was evaluated with it
    bool likely_last = false;
  };

  Iterate evaluate(std::span<const double> du, std::span<double> r, bool with_matrix);
  void accept(const Iterate& next);
  void provide_matrix();
  void solve_linear();
  int solve_supported(double tolerance, const std::string& reason);
  bool is_small(double step) const {
    return step <= settings_.increment_tolerance * problem_.increment_scale();
  }
  bool next_is_last() const;
  double predicted_relative() const;
  bool cycles() const;
  bool line_search();
  bool sufficient(const Iterate& next) const;
  bool raise_regularisation();
  bool ask_for_support();
  void follow_regularisation(double norm_before);
  bool goes_in_circles() const;
  bool is_converged() const;
  bool is_solution() const;
  double dot(std::span<const double> a, std::span<const double> b) const {
    return problem_.shared().dot(a, b);
  }
  std::string describe_worst(std::span<const double> values) const;
  [[noreturn]] void fail(const std::string& reason, const std::string& cause) const;

  NewtonProblem<block_size>& problem_;
  NewtonMatrix<block_size>& matrix_;
  const NewtonSettings& settings_;
  std::span<double> du_;
  PhaseTimes& times_;

  std::vector<double> r_, step_, trial_, trial_r_;
  Iterate current_;
  std::string rejection_;   // why the last trial state was refused
  double step_size_ = 0;    // largest |step| of a node before any cut
  double cut_ = 1;          // s of the last line search
  bool supported_ = false;  // the step at hand
  // supported steps in a row within both limits: no force moves the loose parts
  int idle_supports_ = 0;
  bool wants_support_ = false;  // the next step: K was singular but for round-off
  bool matrix_is_old_ = false;  // the linear solver holds the matrix of an earlier iterate
  Regularisation regularisation_;
  std::size_t plain_since_ = 0;  // first of the residuals since the last regularised step
  NewtonReport report_;
  std::vector<double> norms_;  // |r| of each iterate
};

template <int block_size>
typename Newton<block_size>::Iterate Newton<block_size>::evaluate(std::span<const double> du,
                                                                  std::span<double> r,
                                                                  bool with_matrix) {
  const ScopedTimer timer(times_, "assembly");
  const Evaluation evaluation = problem_.evaluate(du, r, with_matrix ? &matrix_.K : nullptr);
  report_.matrices += with_matrix;
  rejection_.clear();
  Iterate next;
  next.has_matrix = with_matrix;
  next.likely_last = evaluation.likely_last;
  next.norm = evaluation.residual_norm ? *evaluation.residual_norm : problem_.shared().norm(r);
  if (!evaluation.admissible) {
    rejection_ = evaluation.reason.empty() ? "inadmissible state" : evaluation.reason;
  } else if (!std::isfinite(next.norm) || !std::isfinite(evaluation.force_scale)) {
    rejection_ = "residual not finite, worst " + describe_worst(r);
  }
  const double scale = evaluation.force_scale;
  next.small_residual = next.norm <= settings_.residual_tolerance * scale;
  next.relative = next.norm == 0 ? 0 : next.norm / scale;
  return next;
}

template <int block_size>
void Newton<block_size>::accept(const Iterate& next) {
  current_ = next;
  report_.residuals.push_back(next.relative);
  norms_.push_back(next.norm);
}

// Quadratic convergence through the last two residuals; infinite where they do not show it.
template <int block_size>
double Newton<block_size>::predicted_relative() const {
  const auto& residuals = report_.residuals;
  if (residuals.size() < 2) return HUGE_VAL;
  const double before = residuals[residuals.size() - 2], last = residuals.back();
  if (!(last < before)) return HUGE_VAL;
  return last * (last / before) * (last / before);
}

template <int block_size>
bool Newton<block_size>::next_is_last() const {
  return is_small(step_size_) &&
         (current_.small_residual || predicted_relative() <= settings_.residual_tolerance);
}

template <int block_size>
void Newton<block_size>::provide_matrix() {
  if (!current_.has_matrix) {
    const Iterate again = evaluate(du_, r_, true);
    if (!rejection_.empty()) fail(rejection_, "line_search");
    current_ = again;
  }
  matrix_.linear.set_matrix(matrix_.K, problem_.shared());
  matrix_is_old_ = false;
}

template <int block_size>
void Newton<block_size>::solve_linear() {
  const double predicted = predicted_relative();
  const double needed = linear_margin * (std::isfinite(predicted) && !matrix_is_old_
                                             ? std::max(predicted, settings_.residual_tolerance)
                                             : settings_.residual_tolerance);
  // The solver's own setting is the lower bound: a value <= 0 asks for it.
  const double wanted = std::min(needed / current_.relative, loosest_linear_tolerance);
  const ScopedTimer timer(times_, "solve");
  supported_ = false;
  if (wants_support_) {
    wants_support_ = false;
    report_.linear_iterations += solve_supported(wanted, "line search failed");
  } else {
    try {
      report_.linear_iterations += matrix_.linear.solve(r_, step_, wanted);
    } catch (const ConvergenceError& error) {
      report_.linear_iterations += solve_supported(wanted, error.what());
    }
  }
  ++report_.iterations;
  report_.regularised += regularisation_.active();
  step_size_ = problem_.shared().largest(worst_node<block_size>(step_).size);
}

// Solve where K alone has no solution, for this reason. @returns linear iterations
template <int block_size>
int Newton<block_size>::solve_supported(double tolerance, const std::string& reason) {
  if (!problem_.support(true)) fail(reason, "linear_solver");
  evaluate(du_, r_, true);
  problem_.support(false);
  current_.has_matrix = false;
  supported_ = true;
  ++report_.supported;
  try {
    matrix_.linear.set_matrix(matrix_.K, problem_.shared());
    return matrix_.linear.solve(r_, step_, tolerance);
  } catch (const ConvergenceError& error) {
    fail(error.what(), "linear_solver");
  }
}

template <int block_size>
bool Newton<block_size>::sufficient(const Iterate& next) const {
  if (next.small_residual) return true;
  if (regularisation_.active()) return Regularisation::allows(current_.norm, next.norm);
  return next.norm < current_.norm ||
         std::abs(dot(step_, trial_r_)) <= energy_reduction * std::abs(dot(step_, r_));
}

// Across a kink (contact that opens, a point that leaves the yield surface) full steps may jump to
// and fro between two states for ever; half a step lands between them.
template <int block_size>
bool Newton<block_size>::cycles() const {
  const auto& residuals = report_.residuals;
  const std::size_t n = residuals.size();
  return n > 4 && residuals[n - 1] > 0.5 * residuals[n - 3] &&
         residuals[n - 2] > 0.5 * residuals[n - 4];
}

template <int block_size>
bool Newton<block_size>::line_search() {
  const bool speculate = !settings_.reuse_matrix && !current_.likely_last && !next_is_last();
  cut_ = !regularisation_.active() && cycles() ? 0.5 : 1;
  const int most = supported_ ? max_supported_cuts : max_cuts;
  for (int cuts = 0; cuts <= most; ++cuts, cut_ /= 2) {
    for (std::size_t i = 0; i < du_.size(); ++i) trial_[i] = du_[i] + cut_ * step_[i];
    const Iterate next = evaluate(trial_, trial_r_, speculate && cuts == 0);
    if (is_solution() && !next.small_residual) break;
    if (rejection_.empty() && sufficient(next)) {
      std::copy(trial_.begin(), trial_.end(), du_.begin());
      std::swap(r_, trial_r_);
      report_.line_search_cuts += cuts;
      accept(next);
      return true;
    }
    // K, if it was evaluated, belongs to a refused state.
    current_.has_matrix = false;
  }
  return false;
}

// Add stiffness at the kinks of r. @returns false where no more is possible or r has none
template <int block_size>
bool Newton<block_size>::raise_regularisation() {
  if (!regularisation_.raise()) return false;
  if (!problem_.regularise(regularisation_.share())) {
    regularisation_ = {};
    return false;
  }
  current_.has_matrix = false;
  return true;
}

// Add support: a matrix that is singular but for round-off has a solution, along which nothing gets
// better.
// @returns false where no part can be loose, or where support did not help
template <int block_size>
bool Newton<block_size>::ask_for_support() {
  if (supported_ || regularisation_.active() || !problem_.support(false)) return false;
  wants_support_ = true;
  return true;
}

template <int block_size>
void Newton<block_size>::follow_regularisation(double norm_before) {
  if (!regularisation_.active()) return;
  if (current_.small_residual) {
    regularisation_ = {};
  } else {
    regularisation_.follow(norm_before, current_.norm);
  }
  problem_.regularise(regularisation_.share());
  current_.has_matrix = false;
  plain_since_ = report_.residuals.size() - 1;
}

template <int block_size>
bool Newton<block_size>::goes_in_circles() const {
  return !regularisation_.active() && !current_.small_residual &&
         go_in_circles(std::span<const double>(report_.residuals).subspan(plain_since_));
}

// Whether the iterate is the solution after a step was taken.
template <int block_size>
bool Newton<block_size>::is_converged() const {
  if (regularisation_.active()) return false;
  if (supported_) return idle_supports_ == 2;
  return (current_.small_residual && is_small(cut_ * step_size_)) ||
         (!matrix_is_old_ && step_size_ <= increment_round_off * problem_.increment_scale());
}

// Whether the iterate is the solution before the next step is taken: it is within both limits,
// whatever lies beyond a kink.
template <int block_size>
bool Newton<block_size>::is_solution() const {
  return current_.small_residual && !regularisation_.active() && !supported_ && !matrix_is_old_ &&
         is_small(step_size_);
}

template <int block_size>
NewtonReport Newton<block_size>::run() {
  const bool reuse = settings_.reuse_matrix && matrix_.is_usable;
  matrix_.is_usable = false;
  problem_.regularise(0);
  const Iterate first = evaluate(du_, r_, !reuse);
  if (!rejection_.empty()) fail("the guess is inadmissible: " + rejection_, "inadmissible_guess");
  accept(first);
  bool converged = current_.small_residual;
  bool matrix_is_usable = reuse;
  while (!converged) {
    if (report_.iterations == settings_.max_iterations) {
      fail("iteration limit reached", "iteration_limit");
    }
    if (goes_in_circles() && raise_regularisation()) matrix_is_usable = false;
    matrix_is_old_ = matrix_is_usable;
    if (!matrix_is_usable) provide_matrix();
    solve_linear();
    const double norm_before = current_.norm;
    if (line_search()) {
      const bool is_idle = supported_ && current_.small_residual && is_small(step_size_);
      idle_supports_ = is_idle ? idle_supports_ + 1 : 0;
      converged = is_converged();
      matrix_is_usable = settings_.reuse_matrix && !regularisation_.active() && !supported_ &&
                         (converged || current_.norm <= reuse_reduction * norm_before);
      follow_regularisation(norm_before);
    } else if (is_solution()) {
      evaluate(du_, r_, false);
      converged = true;
    } else if (matrix_is_old_ || report_.matrices == 1 || raise_regularisation() ||
               ask_for_support()) {
      matrix_is_usable = false;  // the first K may be that of a neighbouring state
    } else {
      fail("line search failed" + (rejection_.empty() ? "" : ": " + rejection_), "line_search");
    }
  }
  matrix_.is_usable = matrix_is_usable;
  return report_;
}

/// The node with the largest values of all ranks, and their norm.
template <int block_size>
std::string Newton<block_size>::describe_worst(std::span<const double> values) const {
  const WorstNode own = worst_node<block_size>(values);
  const double size = std::isfinite(own.size) ? own.size : HUGE_VAL;
  const bool is_worst = !values.empty() && size == problem_.shared().largest(size);
  return problem_.shared().first_text(
      is_worst ? fmt::format("{} with |r| = {:.3e}", problem_.describe_node(own.node), own.size)
               : "");
}

template <int block_size>
void Newton<block_size>::fail(const std::string& reason, const std::string& cause) const {
  std::string worst = report_.residuals.empty() ? "no residual yet" : "worst " + describe_worst(r_);
  const std::string point = problem_.describe_worst_point(du_);
  if (!point.empty()) worst += "; most strained " + point;
  throw UnbalancedError(
      fmt::format("Newton, iteration {}: {}; {}; |r|/scale: {}", report_.iterations, reason, worst,
                  series_text(report_.residuals)),
      cause, norms_);
}

}  // namespace

template <int block_size>
NewtonReport solve_newton(NewtonProblem<block_size>& problem, NewtonMatrix<block_size>& matrix,
                          const NewtonSettings& settings, std::span<double> du, PhaseTimes& times) {
  return Newton<block_size>(problem, matrix, settings, du, times).run();
}

template NewtonReport solve_newton<2>(NewtonProblem<2>&, NewtonMatrix<2>&, const NewtonSettings&,
                                      std::span<double>, PhaseTimes&);
template NewtonReport solve_newton<3>(NewtonProblem<3>&, NewtonMatrix<3>&, const NewtonSettings&,
                                      std::span<double>, PhaseTimes&);
template NewtonReport solve_newton<4>(NewtonProblem<4>&, NewtonMatrix<4>&, const NewtonSettings&,
                                      std::span<double>, PhaseTimes&);

}  // namespace gabion
