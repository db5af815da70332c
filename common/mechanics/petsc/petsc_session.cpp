// SPDX-License-Identifier: BSD-3-Clause
#include "common/mechanics/petsc/petsc_session.hpp"

#include <petscsys.h>

#include "common/base/error.hpp"

namespace gabion {

PetscSession::PetscSession(MPI_Comm comm) {
  // PETSc keeps the pointers.
  static char name[] = "gabion";
  static char no_signals[] = "-no_signal_handler";
  static char no_files[] = "-skip_petscrc";
  static char* arguments[] = {name, no_signals, no_files, nullptr};
  static char** argv = arguments;
  static int argc = 3;
  PETSC_COMM_WORLD = comm;
  check_petsc(PetscInitialize(&argc, &argv, nullptr, nullptr), "PetscInitialize");
  check_petsc(PetscPushErrorHandler(PetscReturnErrorHandler, nullptr), "PetscPushErrorHandler");
}

PetscSession::~PetscSession() {
  PetscPopErrorHandler();
  PetscFinalize();
}

void check_petsc(int code, const char* call) {
  if (code == 0) return;
  const char* text = nullptr;
  char* specific = nullptr;
  PetscErrorMessage(code, &text, &specific);
  std::string message = std::string("PETSc: ") + call + " failed with code " + std::to_string(code);
  if (text != nullptr) message += std::string(": ") + text;
  if (specific != nullptr && *specific != '\0') message += std::string(" (") + specific + ")";
  throw Error(message);
}

}  // namespace gabion
