// SPDX-License-Identifier: BSD-3-Clause
#include "coupler/run_coupler.hpp"

int main(int argc, char** argv) {
  return gabion::run_program(argc, argv, "coupler", gabion::describe_coupler_keys,
                             gabion::run_coupler);
}
