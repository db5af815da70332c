// SPDX-License-Identifier: BSD-3-Clause
#include "tests/support/mpi_main.hpp"

#include <gtest/gtest.h>

#include <cstdio>

#include "common/base/log.hpp"
#include "common/mechanics/petsc/petsc_session.hpp"
#include "common/program/mpi_session.hpp"

namespace gabion::test {

namespace {

const MpiSession* running = nullptr;

/// Ranks other than 0 speak only of failures.
class FailurePrinter : public testing::EmptyTestEventListener {
  void OnTestPartResult(const testing::TestPartResult& result) override {
    if (result.failed())
      std::printf("[rank %d] %s:%d: %s\n", rank(), result.file_name(), result.line_number(),
                  result.message());
  }
};

}  // namespace

MPI_Comm comm() {
  return running->comm();
}
int rank() {
  return running->rank();
}
int size() {
  return running->size();
}

}  // namespace gabion::test

int main(int argc, char** argv) {
  gabion::MpiSession mpi(argc, argv, "test");
  gabion::test::running = &mpi;
  const gabion::PetscSession petsc(mpi.comm());
  gabion::log::start("test", gabion::log::Level::warn, mpi.is_root());
  testing::InitGoogleTest(&argc, argv);
  if (!mpi.is_root()) {
    auto& listeners = testing::UnitTest::GetInstance()->listeners();
    delete listeners.Release(listeners.default_result_printer());
    listeners.Append(new gabion::test::FailurePrinter);
  }
  int failed = RUN_ALL_TESTS();
  MPI_Allreduce(MPI_IN_PLACE, &failed, 1, MPI_INT, MPI_MAX, mpi.comm());
  return failed;
}
