// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mpi.h>

namespace gabion {

/// Starts PETSc on this program's communicator and ends it on destruction. PETSc's signal handlers
/// stay off, no option file is read (the environment's PETSC_OPTIONS is), and errors come back as
/// codes for check_petsc instead of ending the program.
/// @pre  MPI runs, and keeps running until after the destruction
class PetscSession {
 public:
  explicit PetscSession(MPI_Comm comm);
  ~PetscSession();
  PetscSession(const PetscSession&) = delete;
  PetscSession& operator=(const PetscSession&) = delete;
  PetscSession(PetscSession&&) = delete;
  PetscSession& operator=(PetscSession&&) = delete;
};

/// Throws Error with PETSc's text unless code is 0.
void check_petsc(int code, const char* call);

}  // namespace gabion
