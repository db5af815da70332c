// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mpi.h>

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace gabion {

/// The nodes that this rank shares with others. Each rank holds the nodes that it needs and numbers
/// them 0, 1, …; a node that several ranks hold is owned by the lowest of them. Nodal fields have
/// the values of all held nodes, the same bits on each holder once they were summed. Nobody knows
/// all nodes: the holders of a node find each other through the rank to whose share of the numbers
/// it belongs, then exchange values with each other.
///
/// All functions but the plain numbers are collective; on one rank they cost nothing.
class SharedNodes {
 public:
  /// One rank, which owns all that it holds.
  SharedNodes() = default;
  /// @param ids      of the held nodes in a list that is the same for all ranks, ascending
  /// @param num_ids  length of that list, of which no rank stores anything
  /// @note Collective.
  SharedNodes(MPI_Comm comm, std::span<const std::int32_t> ids, std::int32_t num_ids);

  bool alone() const { return !graph_; }
  /// Another one for each set of holders; 0 where alone.
  std::int64_t id() const;
  bool owns(std::int32_t node) const { return alone() || owns_shared(node); }
  int owner(std::int32_t node) const;  ///< rank; @pre not alone
  /// Number of a held node among those of all ranks: the owned ones of each rank are consecutive.
  /// @pre not alone
  std::span<const std::int32_t> numbers() const;
  std::span<const std::int32_t> owned() const;  ///< held nodes, ascending; @pre not alone
  std::int32_t num_owned() const;               ///< @pre not alone
  std::int64_t num_of_all() const;              ///< owned by any rank; @pre not alone
  std::int32_t num_shared() const;              ///< held by this rank and others; @pre not alone
  int num_neighbours() const;                   ///< ranks that hold some of these; @pre not alone
  int neighbour(int n) const;                   ///< rank, ascending with n; @pre not alone
  /// Nodes of this rank that neighbour n has too, in the same order as there. @pre not alone
  std::span<const std::int32_t> shared_with(int n) const;

  /// Replace the values of each node, of which every holder has a part, by their sum.
  /// @param values  num_held x components
  void sum(std::span<double> values, int components) const;
  /// Like sum() of one field, for two fields in one exchange.
  void sum(std::span<double> a, std::span<double> b, int components) const;
  /// Like sum(), at the owner of each node only; values at nodes of other ranks are left as they
  /// are.
  void add_to_owners(std::span<double> values, int components) const;
  /// Replace the values of each node by its owner's.
  void take_from_owners(std::span<double> values, int components) const;

  /// Sum of one number of each rank.
  double total(double own) const;
  void total(std::span<double> own) const;
  double largest(double own) const;
  bool all(bool own) const;
  /// The text of the lowest rank that has one.
  std::string first_text(std::string own) const;

  /// sum_i a_i b_i over the nodes of all ranks, each once. @param a, b  num_held x components
  double dot(std::span<const double> a, std::span<const double> b) const;
  double own_dot(std::span<const double> a, std::span<const double> b) const;  ///< its own nodes
  double norm(std::span<const double> a) const;

 private:
  struct Graph;
  bool owns_shared(std::int32_t node) const;
  std::shared_ptr<const Graph> graph_;
};

}  // namespace gabion
