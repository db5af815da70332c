// SPDX-License-Identifier: BSD-3-Clause
// Data sent to other ranks is counted, whoever sends it.
#include <gtest/gtest.h>
#include <mpi.h>

#include <vector>

#include "common/base/error.hpp"
#include "common/mechanics/petsc/linear_solver.hpp"
#include "common/mechanics/ranks/sum.hpp"
#include "solver_program/mpi_traffic.hpp"
#include "tests/support/mpi_main.hpp"

namespace gabion::test::test_mpi_traffic {
namespace {

template <class Work>
MpiTraffic traffic_of(const Work& work) {
  const auto before = mpi_traffic();
  work();
  if (!before) throw Error("nobody counts: gabion_mpi_counter is not loaded before MPI");
  return *mpi_traffic() - *before;
}

TEST(MpiTraffic, messages_and_their_bytes_are_counted) {
  const int right = (rank() + 1) % size(), left = (rank() + size() - 1) % size();
  const std::vector<double> sent(5, 1.0);
  std::vector<double> received(5);
  const MpiTraffic traffic = traffic_of([&] {
    MPI_Request requests[2];
    MPI_Irecv(received.data(), 5, MPI_DOUBLE, left, 1, comm(), &requests[0]);
    MPI_Isend(sent.data(), 5, MPI_DOUBLE, right, 1, comm(), &requests[1]);
    MPI_Waitall(2, requests, MPI_STATUSES_IGNORE);
  });
  EXPECT_EQ(received, sent);
  EXPECT_EQ(traffic.messages, 1);
  EXPECT_EQ(traffic.message_bytes, 40);
  EXPECT_EQ(traffic.collectives, 0);
  EXPECT_GT(traffic.waiting_seconds, 0);
}

TEST(MpiTraffic, prepared_messages_are_counted_when_they_are_sent) {
  const int right = (rank() + 1) % size(), left = (rank() + size() - 1) % size();
  double sent = 3, received = 0;
  MPI_Request requests[2];
  const MpiTraffic traffic = traffic_of([&] {
    MPI_Send_init(&sent, 1, MPI_DOUBLE, right, 1, comm(), &requests[0]);
    MPI_Recv_init(&received, 1, MPI_DOUBLE, left, 1, comm(), &requests[1]);
  });
  EXPECT_EQ(traffic.messages, 0);
  const MpiTraffic twice = traffic_of([&] {
    for (int k = 0; k < 2; ++k) {
      MPI_Startall(2, requests);
      MPI_Waitall(2, requests, MPI_STATUSES_IGNORE);
    }
  });
  EXPECT_EQ(twice.messages, 2);
  EXPECT_EQ(twice.message_bytes, 16);
  for (MPI_Request& request : requests) MPI_Request_free(&request);
}

TEST(MpiTraffic, collectives_of_several_ranks_are_counted) {
  const MpiTraffic traffic = traffic_of([&] {
    std::vector<double> values(3, 1.0);
    MPI_Allreduce(MPI_IN_PLACE, values.data(), 3, MPI_DOUBLE, MPI_SUM, comm());
    MPI_Barrier(comm());
    MPI_Allreduce(MPI_IN_PLACE, values.data(), 3, MPI_DOUBLE, MPI_SUM, MPI_COMM_SELF);
  });
  EXPECT_EQ(traffic.collectives, size() > 1 ? 2 : 0);
  EXPECT_EQ(traffic.collective_bytes, size() > 1 ? 24 : 0);
}

// A row of masses on springs, held at one end; every rank has all nodes.
TEST(MpiTraffic, what_petsc_sends_is_seen) {
  constexpr std::int32_t num_nodes = 40;
  BlockMatrix<2> K;
  std::vector<std::int32_t> offsets = {0}, nodes;
  for (std::int32_t c = 0; c + 1 < num_nodes; ++c) {
    nodes.insert(nodes.end(), {c, c + 1});
    offsets.push_back(static_cast<std::int32_t>(nodes.size()));
  }
  K.set_pattern(num_nodes, offsets, nodes);
  if (rank() == 0) {
    for (std::int32_t i = 0; i < num_nodes; ++i) {
      K.add_diagonal(i, 2.1);
      if (i > 0) K.add_block(i, i - 1, -NodeBlock<2>::Identity());
      if (i + 1 < num_nodes) K.add_block(i, i + 1, -NodeBlock<2>::Identity());
    }
  }
  const std::vector<double> b(2 * num_nodes, 1.0);
  std::vector<double> x(b.size());
  LinearSolver<2> solver(comm(), 2, {.method = "bicgstab", .preconditioner = "jacobi"});
  solver.set_matrix(K);
  int iterations = 0;
  const MpiTraffic traffic = traffic_of([&] { iterations = solver.solve(b, x); });
  ASSERT_GT(iterations, 2);
  if (size() == 1) {
    EXPECT_EQ(traffic.messages, 0);
    EXPECT_EQ(traffic.collectives, 0);
  } else {
    // Two products an iteration, each with a message to every neighbour; three sums or more.
    const bool inside = rank() > 0 && rank() + 1 < size();
    EXPECT_GE(traffic.messages, 2 * iterations * (inside ? 2 : 1));
    EXPECT_GE(traffic.collectives, 3 * iterations);
  }
}

}  // namespace
}  // namespace gabion::test::test_mpi_traffic
