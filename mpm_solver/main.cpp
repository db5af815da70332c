// SPDX-License-Identifier: BSD-3-Clause
#include "common/program/program.hpp"
#include "mpm_solver/run_mpm.hpp"

int main(int argc, char** argv) {
  return gabion::run_program(argc, argv, "mpm_solver", gabion::describe_mpm_keys, gabion::run_mpm);
}
