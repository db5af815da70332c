// SPDX-License-Identifier: BSD-3-Clause
#include "common/program/program.hpp"
#include "fem_solver/run_fem.hpp"

int main(int argc, char** argv) {
  return gabion::run_program(argc, argv, "fem_solver", gabion::describe_fem_keys, gabion::run_fem);
}
