// SPDX-License-Identifier: BSD-3-Clause
// A library to load before that of MPI: functions of MPI under their own names, which count and
// call those of the library by theirs with a P (profiling interface, MPI standard 4.0, chapter 15).
#include <mpi.h>

#include <cstdint>
#include <map>

#include "solver_program/mpi_traffic.hpp"

namespace gabion {

namespace {

MpiTraffic traffic;
std::map<MPI_Request, std::int64_t> prepared;  // bytes of messages that are sent again and again

std::int64_t bytes_of(std::int64_t count, MPI_Datatype type) {
  int size = 0;
  if (type != MPI_DATATYPE_NULL) PMPI_Type_size(type, &size);
  return count * size;
}

template <class Call>
int waiting(const Call& call) {
  const double start = PMPI_Wtime();
  const int result = call();
  traffic.waiting_seconds += PMPI_Wtime() - start;
  return result;
}

void count_message(std::int64_t bytes) {
  ++traffic.messages;
  traffic.message_bytes += bytes;
}

void count_collective(MPI_Comm comm, std::int64_t count, MPI_Datatype type) {
  int size = 1;
  PMPI_Comm_size(comm, &size);
  if (size == 1) return;
  ++traffic.collectives;
  traffic.collective_bytes += bytes_of(count, type);
}

template <class Call>
int collective(MPI_Comm comm, std::int64_t count, MPI_Datatype type, const Call& call) {
  count_collective(comm, count, type);
  return waiting(call);
}

void count_prepared(MPI_Request request) {
  const auto found = prepared.find(request);
  if (found != prepared.end()) count_message(found->second);
}

}  // namespace

// Names and arguments are those of the standard.
extern "C" {

void gabion_mpi_traffic(MpiTraffic* so_far) {
  *so_far = traffic;
}

int MPI_Send(const void* data, int count, MPI_Datatype type, int to, int tag, MPI_Comm comm) {
  count_message(bytes_of(count, type));
  return waiting([&] { return PMPI_Send(data, count, type, to, tag, comm); });
}

int MPI_Isend(const void* data, int count, MPI_Datatype type, int to, int tag, MPI_Comm comm,
              MPI_Request* request) {
  count_message(bytes_of(count, type));
  return PMPI_Isend(data, count, type, to, tag, comm, request);
}

int MPI_Issend(const void* data, int count, MPI_Datatype type, int to, int tag, MPI_Comm comm,
               MPI_Request* request) {
  count_message(bytes_of(count, type));
  return PMPI_Issend(data, count, type, to, tag, comm, request);
}

int MPI_Send_init(const void* data, int count, MPI_Datatype type, int to, int tag, MPI_Comm comm,
                  MPI_Request* request) {
  const int result = PMPI_Send_init(data, count, type, to, tag, comm, request);
  prepared[*request] = bytes_of(count, type);
  return result;
}

int MPI_Request_free(MPI_Request* request) {
  prepared.erase(*request);
  return PMPI_Request_free(request);
}

int MPI_Start(MPI_Request* request) {
  count_prepared(*request);
  return PMPI_Start(request);
}

int MPI_Startall(int count, MPI_Request* requests) {
  for (int k = 0; k < count; ++k) count_prepared(requests[k]);
  return PMPI_Startall(count, requests);
}

int MPI_Recv(void* data, int count, MPI_Datatype type, int from, int tag, MPI_Comm comm,
             MPI_Status* status) {
  return waiting([&] { return PMPI_Recv(data, count, type, from, tag, comm, status); });
}

int MPI_Probe(int from, int tag, MPI_Comm comm, MPI_Status* status) {
  return waiting([&] { return PMPI_Probe(from, tag, comm, status); });
}

int MPI_Wait(MPI_Request* request, MPI_Status* status) {
  return waiting([&] { return PMPI_Wait(request, status); });
}

int MPI_Waitall(int count, MPI_Request* requests, MPI_Status* statuses) {
  return waiting([&] { return PMPI_Waitall(count, requests, statuses); });
}

int MPI_Waitany(int count, MPI_Request* requests, int* index, MPI_Status* status) {
  return waiting([&] { return PMPI_Waitany(count, requests, index, status); });
}

int MPI_Barrier(MPI_Comm comm) {
  return collective(comm, 0, MPI_BYTE, [&] { return PMPI_Barrier(comm); });
}

int MPI_Bcast(void* data, int count, MPI_Datatype type, int root, MPI_Comm comm) {
  return collective(comm, count, type, [&] { return PMPI_Bcast(data, count, type, root, comm); });
}

int MPI_Allreduce(const void* own, void* all, int count, MPI_Datatype type, MPI_Op op,
                  MPI_Comm comm) {
  return collective(comm, count, type,
                    [&] { return PMPI_Allreduce(own, all, count, type, op, comm); });
}

int MPI_Reduce_scatter_block(const void* own, void* all, int count, MPI_Datatype type, MPI_Op op,
                             MPI_Comm comm) {
  return collective(comm, count, type,
                    [&] { return PMPI_Reduce_scatter_block(own, all, count, type, op, comm); });
}

int MPI_Scan(const void* own, void* all, int count, MPI_Datatype type, MPI_Op op, MPI_Comm comm) {
  return collective(comm, count, type, [&] { return PMPI_Scan(own, all, count, type, op, comm); });
}

int MPI_Exscan(const void* own, void* all, int count, MPI_Datatype type, MPI_Op op, MPI_Comm comm) {
  return collective(comm, count, type,
                    [&] { return PMPI_Exscan(own, all, count, type, op, comm); });
}

int MPI_Allgather(const void* own, int count, MPI_Datatype type, void* all, int counts,
                  MPI_Datatype types, MPI_Comm comm) {
  return collective(comm, count, type,
                    [&] { return PMPI_Allgather(own, count, type, all, counts, types, comm); });
}

int MPI_Allgatherv(const void* own, int count, MPI_Datatype type, void* all, const int counts[],
                   const int starts[], MPI_Datatype types, MPI_Comm comm) {
  return collective(comm, count, type, [&] {
    return PMPI_Allgatherv(own, count, type, all, counts, starts, types, comm);
  });
}

int MPI_Gather(const void* own, int count, MPI_Datatype type, void* all, int counts,
               MPI_Datatype types, int root, MPI_Comm comm) {
  return collective(comm, count, type,
                    [&] { return PMPI_Gather(own, count, type, all, counts, types, root, comm); });
}

int MPI_Gatherv(const void* own, int count, MPI_Datatype type, void* all, const int counts[],
                const int starts[], MPI_Datatype types, int root, MPI_Comm comm) {
  return collective(comm, count, type, [&] {
    return PMPI_Gatherv(own, count, type, all, counts, starts, types, root, comm);
  });
}

}  // extern "C"

}  // namespace gabion
