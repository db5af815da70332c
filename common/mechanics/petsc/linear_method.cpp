// SPDX-License-Identifier: BSD-3-Clause
#include "common/mechanics/petsc/linear_method.hpp"

#include <limits>

namespace gabion {

namespace {

// Crossovers of "auto" for symmetric matrices. Plane column 0.2 x 0.1 m of triangles, E 840 kPa, nu
// 0.3, 2650 kg/m3, a third of the cells with an unsymmetric plastic tangent; ms for new values,
// set-up and solve to 1e-8:
//
//     dofs   method               Courant 0.4   0.8   1.5    3     5     8     12    20    inf
//     1722   bicgstab + jacobi           0.21  0.32  0.36  0.9   1.2   1.8   2.3   3.3    19
//            bicgstab + ilu(0)           0.22  0.27  0.31  0.46  0.64  0.89  1.2   1.7   2.5
//            block lu                    0.86  the same for all
//     3306   bicgstab + jacobi           0.24  0.39  0.64  1.5   2.1   3.4   4.9    15    34
//            bicgstab + ilu(0)           0.43  0.53  0.62  0.90  1.3   1.8   2.7   3.6   6.5
//            block lu                    3.1   the same for all
//
// A new pattern adds 0.2 ms to the Krylov methods and 0.8 / 1.5 ms to block lu.
//
// Unsymmetric matrices of sand that collapses (scenes of scripts/bench instructions, some 10 to 60
// steps of 0.08 to 5 ms): Krylov iterations a Newton iteration, and processor time of the run [s].
// Elimination in the pattern meets pivots near zero and below where soil yields:
//
//                          Courant    bicgstab + jacobi    bicgstab + ilu(0)
//     quad4, linear              1      2.7    0.28          1.0    0.30
//                                3      8.7    0.31          1.9    0.30
//                               10     20.2    0.47         44.1    1.36  fails
//     quad4, gimp                3      8.5    0.46          1.4    0.56
//                               10     21.9    0.95          9.0    1.46
//       of 10,000 dofs          20     17.7    3.7          22.7   19     fails
//     tri3                      10     22.8    0.69         12.7    0.75
//     hex8, linear               3      7.7    0.57          2.0    0.68
//                               10     17.5    0.97         36.2    4.66  fails
//       of 28,000 dofs          20     38      5.8          16    123     fails
//       the same at rest       207     20      1.3          37      2.3
//     hex8, gimp                 3      8.0    0.85          1.6    1.58
//                               10     21.1    1.40         15.6    2.89
//
// Sweeps of Gauss and Seidel take half the iterations of jacobi, and its time.
constexpr double jacobi_courant = 1.2;       // below: node-block Jacobi, above: block ILU(0)
constexpr double direct_courant_small = 15;  // above: direct in 2D with few unknowns
constexpr double direct_courant = 25;        // above: direct otherwise
constexpr std::int64_t small_dofs_2d = 5000;
constexpr std::int64_t lu_dofs_2d = 12000;  // below: block LU, above: MUMPS
constexpr std::int64_t lu_dofs_3d = 1000;
constexpr std::int64_t direct_dofs_3d = 1000;  // 3D problems above this are never direct

// Multigrid in space, symmetric matrices of hex8. Iterations to 1e-8, seconds for set-up and
// solution:
//
//     statics            cg + ilu(0)    cg + multigrid
//     wall of 38,000       628   2.5         38   1.3
//     block of 12,000       57   0.2         14   0.5
//     block of 47,000       85   0.6         16   1.3
//     block of 207,000     143   5.2         16   7.2   (2.3 without the set-up)
//     wall of 290,000   > 2000               58   22
//     Courant 64
//     wall of 38,000       145   1.1         24   1.3
//     block of 47,000       76   1.2         15   1.8
//
// Newton's method asks for less than 1e-8, which favours ilu(0): a block of 292,000 takes it 16 s,
// 45 s with multigrid; in a wall four cells thick of 185,000 it fails, multigrid takes 24 s
// (docs/measured/solvers.md). Unsymmetric matrices of soil that rests, 64,000 unknowns: bicgstab +
// ilu(0) 46 iterations, multigrid 69 and ten times the time.
constexpr std::int64_t multigrid_dofs_3d = 20000;
constexpr double multigrid_courant = 80;

// Smooth functions in space, whose rows have up to 343 blocks: a cylinder of sand of 1,000 nodes
// that falls (configs/column_run_out_3d, other moduli), iterations and ms of a Newton iteration:
//
//     Courant               6           13          26
//     bicgstab + jacobi     16   15     31   16     41   35
//     bicgstab + ilu(0)      2   45     14   68      -
//
// At 26 ilu(0) fails in part of the systems.
constexpr double jacobi_courant_wide = 25;

std::string name_of(Preconditioner preconditioner) {
  switch (preconditioner) {
    case Preconditioner::jacobi:
      return "node-block jacobi";
    case Preconditioner::ilu:
      return "block ilu(0)";
    case Preconditioner::multigrid:
      return "multigrid";
    case Preconditioner::none:
      return "nothing";
  }
  return {};
}

Preconditioner choose_preconditioner(const LinearSolverSettings& settings,
                                     const LinearRegime& regime, int dim, std::int64_t num_dofs) {
  if (settings.preconditioner == "jacobi") return Preconditioner::jacobi;
  if (settings.preconditioner == "ilu") return Preconditioner::ilu;
  if (settings.preconditioner == "multigrid") return Preconditioner::multigrid;
  if (!regime.symmetric || regime.courant <= (regime.wide ? jacobi_courant_wide : jacobi_courant))
    return Preconditioner::jacobi;
  const bool multigrid = dim == 3 && regime.slender && num_dofs > multigrid_dofs_3d &&
                         regime.courant > multigrid_courant;
  return multigrid ? Preconditioner::multigrid : Preconditioner::ilu;
}

bool direct_is_faster(const LinearRegime& regime, int dim, std::int64_t num_dofs) {
  if (dim == 3) return num_dofs <= direct_dofs_3d && regime.courant > direct_courant;
  return regime.courant > (num_dofs <= small_dofs_2d ? direct_courant_small : direct_courant);
}

}  // namespace

KeyTable linear_solver_keys() {
  const LinearSolverSettings defaults;
  return {
      "linear_solver",
      "How each linear system of Newton's method is solved.",
      {key::choice("method", {"auto", "lu", "mumps", "bicgstab", "gmres", "cg"},
                   "`auto`: the fastest one for size, shape and step (docs/measured/solvers.md). "
                   "Direct methods: `lu` (node blocks; on several ranks it is `mumps`) and "
                   "`mumps`. Krylov methods: the others.")
           .or_else(defaults.method),
       key::choice("preconditioner", {"auto", "jacobi", "ilu", "multigrid"},
                   "Preconditioner of a Krylov method: `jacobi` (node blocks), `ilu` (node blocks, "
                   "no fill) or `multigrid` (smoothed aggregation); with a direct method only "
                   "`auto`.")
           .or_else(defaults.preconditioner),
       key::number("tolerance", "",
                   "Smallest true residual, over the right-hand side, that Newton's method may ask "
                   "for.")
           .in(in_words(between(std::numeric_limits<double>::epsilon(), 1e-2),
                        "a number from 2.3e-16 (rounding of the right-hand side) to 0.01"))
           .or_else(defaults.tolerance),
       key::integer(
           "max_iterations",
           "Iterations of a Krylov method after which the direct one takes over, for this step and "
           "4 more. Each further failure in a row doubles that number of steps, up to 64.")
           .in(at_least(1))
           .or_else(defaults.max_iterations)}};
}

LinearSolverSettings read_linear_solver_settings(ConfigReader in) {
  LinearSolverSettings settings;
  settings.method = in.choice("method");
  settings.preconditioner = in.choice("preconditioner");
  settings.tolerance = in.number("tolerance");
  settings.max_iterations = in.integer("max_iterations");
  if ((settings.method == "lu" || settings.method == "mumps") && settings.preconditioner != "auto")
    in.fail("preconditioner", "found \"" + settings.preconditioner +
                                  "\" with the direct method \"" + settings.method +
                                  "\", allowed there: \"auto\"");
  in.finish();
  return settings;
}

std::string LinearMethod::name() const {
  const auto krylov = [this](const std::string& name) {
    return name + " + " + name_of(preconditioner);
  };
  switch (method) {
    case SolutionMethod::lu:
      return "block lu";
    case SolutionMethod::mumps:
      return "mumps lu";
    case SolutionMethod::bicgstab:
      return krylov("bicgstab");
    case SolutionMethod::gmres:
      return krylov("gmres(60)");
    case SolutionMethod::cg:
      return krylov("cg");
  }
  return {};
}

std::int64_t LinearMethod::number() const {
  return 10 * static_cast<std::int64_t>(method) + static_cast<std::int64_t>(preconditioner);
}

SolutionMethod choose_direct_method(int dim, std::int64_t num_dofs, int num_ranks) {
  const bool small = num_dofs <= (dim == 2 ? lu_dofs_2d : lu_dofs_3d);
  return small && num_ranks == 1 ? SolutionMethod::lu : SolutionMethod::mumps;
}

LinearMethod choose_linear_method(const LinearSolverSettings& settings, const LinearRegime& regime,
                                  int dim, std::int64_t num_dofs, int num_ranks) {
  if (settings.method == "mumps") return {SolutionMethod::mumps, Preconditioner::none};
  if (settings.method == "lu")
    return {num_ranks == 1 ? SolutionMethod::lu : SolutionMethod::mumps, Preconditioner::none};
  const bool any_krylov = settings.preconditioner != "auto";
  if (settings.method == "auto" && !any_krylov && direct_is_faster(regime, dim, num_dofs))
    return {choose_direct_method(dim, num_dofs, num_ranks), Preconditioner::none};
  const Preconditioner preconditioner = choose_preconditioner(settings, regime, dim, num_dofs);
  if (settings.method == "gmres") return {SolutionMethod::gmres, preconditioner};
  if (settings.method == "bicgstab") return {SolutionMethod::bicgstab, preconditioner};
  if (settings.method == "cg" || regime.symmetric) return {SolutionMethod::cg, preconditioner};
  return {SolutionMethod::bicgstab, preconditioner};
}

}  // namespace gabion
