// SPDX-License-Identifier: BSD-3-Clause
#include "common/mechanics/ranks/shared_nodes.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "common/mechanics/norm.hpp"
#include "common/mechanics/ranks/packet.hpp"
#include "common/mechanics/ranks/sum.hpp"
#include "common/mechanics/ranks/text.hpp"

namespace gabion {

namespace {

constexpr int message_tag = 7301;

// The ranks that hold each node of this rank, ascending, one node after the other.
struct Holders {
  std::vector<int> ranks;
  std::vector<std::size_t> starts = {0};
  std::span<const int> of(std::size_t node) const {
    return std::span(ranks).subspan(starts[node], starts[node + 1] - starts[node]);
  }
};

// The ids are shared out among the ranks, whoever holds the nodes: this rank was asked for some of
// its share and tells those who asked, of each id in their order, how many asked for it and who.
Packets tell_holders(const Packets& asked) {
  std::vector<std::pair<std::int32_t, int>> held;  // id and holder
  for (const auto& [rank, packet] : asked) {
    for (Packet ids = packet; !ids.empty();) held.emplace_back(ids.take<std::int32_t>(), rank);
  }
  std::ranges::sort(held);
  Packets told;
  for (const auto& [rank, packet] : asked) {
    for (Packet ids = packet; !ids.empty();) {
      const auto holders = std::ranges::equal_range(held, ids.take<std::int32_t>(), {},
                                                    [](auto& h) { return h.first; });
      told[rank].put(static_cast<int>(holders.size()));
      for (const auto& [id, holder] : holders) told[rank].put(holder);
    }
  }
  return told;
}

Holders find_holders(MPI_Comm comm, std::span<const std::int32_t> ids, std::int32_t num_ids) {
  const std::int32_t share = num_ids / num_ranks(comm) + 1;
  Packets asked;
  for (const std::int32_t id : ids) asked[id / share].put(id);
  Packets told = send_packets(comm, tell_holders(send_packets(comm, asked)));
  Holders holders;
  for (auto& [rank, packet] : told) {  // ids ascend with the ranks that were asked
    while (!packet.empty()) {
      const int count = packet.take<int>();
      for (int k = 0; k < count; ++k) holders.ranks.push_back(packet.take<int>());
      holders.starts.push_back(holders.ranks.size());
    }
  }
  return holders;
}

// Another rank and the nodes that this rank exchanges with it, in the order of their ids.
struct Neighbour {
  int rank = 0;
  std::vector<std::int32_t> shared{};
  std::vector<std::int32_t> owned{};   // nodes of `shared` owned by this rank
  std::vector<std::int32_t> theirs{};  // nodes of `shared` owned by the other one
};

using NodeList = std::vector<std::int32_t> Neighbour::*;

}  // namespace

struct SharedNodes::Graph {
  Graph(MPI_Comm comm_, std::span<const std::int32_t> ids, std::int32_t num_ids)
      : comm(comm_), rank(rank_of(comm_)) {
    static std::int64_t last_id = 0;  // all ranks count alike
    id = ++last_id;
    const Holders holders = find_holders(comm, ids, num_ids);
    for (std::size_t i = 0; i < ids.size(); ++i) owners.push_back(holders.of(i).front());
    find_neighbours(holders);
    number_nodes();
  }

  void find_neighbours(const Holders& holders) {
    std::map<int, Neighbour> found;
    for (std::size_t i = 0; i < owners.size(); ++i) {
      const auto node = static_cast<std::int32_t>(i);
      if (owners[i] == rank) owned.push_back(node);
      for (const int r : holders.of(i)) {
        if (r == rank) continue;
        Neighbour& neighbour = found[r];
        neighbour.rank = r;
        neighbour.shared.push_back(node);
        if (owners[i] == rank) neighbour.owned.push_back(node);
        if (owners[i] == r) neighbour.theirs.push_back(node);
      }
    }
    for (auto& [r, neighbour] : found) neighbours.push_back(std::move(neighbour));
  }

  void number_nodes() {
    const auto own = static_cast<std::int64_t>(owned.size());
    std::int64_t end = 0;
    MPI_Scan(&own, &end, 1, MPI_INT64_T, MPI_SUM, comm);
    MPI_Allreduce(&own, &num_of_all, 1, MPI_INT64_T, MPI_SUM, comm);
    numbers.assign(owners.size(), -1);
    auto next = static_cast<std::int32_t>(end - own);
    for (const std::int32_t i : owned) numbers[i] = next++;
    const std::vector<double> given(numbers.begin(), numbers.end());
    const auto parts = exchange(given, 1, &Neighbour::owned, &Neighbour::theirs);
    for (std::size_t n = 0; n < parts.size(); ++n) {
      for (std::size_t k = 0; k < parts[n].size(); ++k) {
        numbers[neighbours[n].theirs[k]] = static_cast<std::int32_t>(parts[n][k]);
      }
    }
  }

  /// Values of the listed nodes of each neighbour, one after the other.
  std::vector<std::vector<double>> exchange(std::span<const double> values, int components,
                                            NodeList given, NodeList taken) const {
    const auto width = static_cast<std::size_t>(components);
    std::vector<std::vector<double>> in(neighbours.size()), out(neighbours.size());
    std::vector<MPI_Request> requests;
    for (std::size_t k = 0; k < neighbours.size(); ++k) {
      const Neighbour& neighbour = neighbours[k];
      in[k].resize((neighbour.*taken).size() * width);
      for (const std::int32_t i : neighbour.*given) {
        const double* of_node = values.data() + static_cast<std::size_t>(i) * width;
        out[k].insert(out[k].end(), of_node, of_node + width);
      }
      if (!in[k].empty()) {
        MPI_Irecv(in[k].data(), static_cast<int>(in[k].size()), MPI_DOUBLE, neighbour.rank,
                  message_tag, comm, &requests.emplace_back());
      }
      if (!out[k].empty()) {
        MPI_Isend(out[k].data(), static_cast<int>(out[k].size()), MPI_DOUBLE, neighbour.rank,
                  message_tag, comm, &requests.emplace_back());
      }
    }
    MPI_Waitall(static_cast<int>(requests.size()), requests.data(), MPI_STATUSES_IGNORE);
    return in;
  }

  MPI_Comm comm;
  int rank = 0;
  std::int64_t id = 0;
  std::vector<int> owners;          // ranks
  std::vector<std::int32_t> owned;  // ascending
  std::vector<std::int32_t> numbers;
  std::int64_t num_of_all = 0;
  std::vector<Neighbour> neighbours;  // ascending ranks
};

SharedNodes::SharedNodes(MPI_Comm comm, std::span<const std::int32_t> ids, std::int32_t num_ids) {
  if (num_ranks(comm) > 1) graph_ = std::make_shared<const Graph>(comm, ids, num_ids);
}

std::int64_t SharedNodes::id() const {
  return alone() ? 0 : graph_->id;
}

bool SharedNodes::owns_shared(std::int32_t node) const {
  return graph_->owners[node] == graph_->rank;
}

int SharedNodes::owner(std::int32_t node) const {
  return graph_->owners[node];
}

std::span<const std::int32_t> SharedNodes::numbers() const {
  return graph_->numbers;
}

std::span<const std::int32_t> SharedNodes::owned() const {
  return graph_->owned;
}

std::int32_t SharedNodes::num_owned() const {
  return static_cast<std::int32_t>(graph_->owned.size());
}

std::int64_t SharedNodes::num_of_all() const {
  return graph_->num_of_all;
}

std::int32_t SharedNodes::num_shared() const {
  std::vector<char> is_shared(graph_->owners.size(), 0);
  for (const Neighbour& neighbour : graph_->neighbours) {
    for (const std::int32_t i : neighbour.shared) is_shared[i] = 1;
  }
  return static_cast<std::int32_t>(std::count(is_shared.begin(), is_shared.end(), 1));
}

int SharedNodes::num_neighbours() const {
  return static_cast<int>(graph_->neighbours.size());
}

int SharedNodes::neighbour(int n) const {
  return graph_->neighbours[n].rank;
}

std::span<const std::int32_t> SharedNodes::shared_with(int n) const {
  return graph_->neighbours[n].shared;
}

// Parts are added in the order of the ranks: each holder gets the same bits.
void SharedNodes::sum(std::span<double> values, int components) const {
  if (alone()) return;
  const auto width = static_cast<std::size_t>(components);
  const auto parts = graph_->exchange(values, components, &Neighbour::shared, &Neighbour::shared);
  const std::vector<double> own(values.begin(), values.end());
  for (const Neighbour& neighbour : graph_->neighbours) {
    for (const std::int32_t i : neighbour.shared) {
      std::fill_n(&values[static_cast<std::size_t>(i) * width], width, 0.0);
    }
  }
  std::vector<char> has_own(graph_->owners.size(), 0);
  const auto add_own = [&](std::int32_t i) {
    if (has_own[i] != 0) return;
    has_own[i] = 1;
    const std::size_t first = static_cast<std::size_t>(i) * width;
    for (std::size_t k = first; k < first + width; ++k) values[k] += own[k];
  };
  for (std::size_t n = 0; n < parts.size(); ++n) {
    const Neighbour& neighbour = graph_->neighbours[n];
    const double* part = parts[n].data();
    for (const std::int32_t i : neighbour.shared) {
      if (neighbour.rank > graph_->rank) add_own(i);
      for (std::size_t k = 0; k < width; ++k) {
        values[static_cast<std::size_t>(i) * width + k] += *part++;
      }
    }
  }
  for (const Neighbour& neighbour : graph_->neighbours) {
    for (const std::int32_t i : neighbour.shared) add_own(i);
  }
}

void SharedNodes::sum(std::span<double> a, std::span<double> b, int components) const {
  if (alone()) return;
  const auto width = static_cast<std::size_t>(components);
  std::vector<double> both;
  both.reserve(2 * a.size());
  for (std::size_t k = 0; k < a.size(); k += width) {
    both.insert(both.end(), &a[k], &a[k] + width);
    both.insert(both.end(), &b[k], &b[k] + width);
  }
  sum(both, 2 * components);
  const double* next = both.data();
  for (std::size_t k = 0; k < a.size(); k += width) {
    std::copy_n(next, width, &a[k]);
    std::copy_n(next + width, width, &b[k]);
    next += 2 * width;
  }
}

void SharedNodes::add_to_owners(std::span<double> values, int components) const {
  if (alone()) return;
  const auto width = static_cast<std::size_t>(components);
  const auto parts = graph_->exchange(values, components, &Neighbour::theirs, &Neighbour::owned);
  for (std::size_t n = 0; n < parts.size(); ++n) {
    const double* part = parts[n].data();
    for (const std::int32_t i : graph_->neighbours[n].owned) {
      for (std::size_t k = 0; k < width; ++k) {
        values[static_cast<std::size_t>(i) * width + k] += *part++;
      }
    }
  }
}

void SharedNodes::take_from_owners(std::span<double> values, int components) const {
  if (alone()) return;
  const auto width = static_cast<std::size_t>(components);
  const auto parts = graph_->exchange(values, components, &Neighbour::owned, &Neighbour::theirs);
  for (std::size_t n = 0; n < parts.size(); ++n) {
    const double* part = parts[n].data();
    for (const std::int32_t i : graph_->neighbours[n].theirs) {
      std::copy_n(part, width, &values[static_cast<std::size_t>(i) * width]);
      part += width;
    }
  }
}

double SharedNodes::total(double own) const {
  total(std::span<double>(&own, 1));
  return own;
}

void SharedNodes::total(std::span<double> own) const {
  if (!alone()) sum_over_ranks(graph_->comm, own);
}

double SharedNodes::largest(double own) const {
  return alone() ? own : max_over_ranks(graph_->comm, own);
}

bool SharedNodes::all(bool own) const {
  return alone() ? own : max_over_ranks(graph_->comm, own ? 0 : 1) == 0;
}

std::string SharedNodes::first_text(std::string own) const {
  return alone() ? own : gabion::first_text(graph_->comm, std::move(own));
}

double SharedNodes::dot(std::span<const double> a, std::span<const double> b) const {
  return total(own_dot(a, b));
}

double SharedNodes::own_dot(std::span<const double> a, std::span<const double> b) const {
  double sum = 0;
  if (alone()) {
    for (std::size_t k = 0; k < a.size(); ++k) sum += a[k] * b[k];
    return sum;
  }
  const std::size_t components = a.empty() ? 0 : a.size() / graph_->owners.size();
  for (const std::int32_t i : graph_->owned) {
    for (std::size_t k = i * components; k < (i + 1) * components; ++k) sum += a[k] * b[k];
  }
  return sum;
}

double SharedNodes::norm(std::span<const double> a) const {
  return alone() ? norm_of(a) : std::sqrt(dot(a, a));
}

}  // namespace gabion
