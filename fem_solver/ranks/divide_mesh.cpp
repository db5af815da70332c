// SPDX-License-Identifier: BSD-3-Clause
#include "fem_solver/ranks/divide_mesh.hpp"

#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "common/mechanics/ranks/packet.hpp"
#include "common/mechanics/ranks/partition.hpp"
#include "common/mechanics/ranks/sum.hpp"
#include "common/mechanics/ranks/text.hpp"

namespace gabion::fem {

namespace {

template <int dim>
MeshPart<dim> part_of_box(const BoxShape<dim>& box, MPI_Comm comm) {
  check_box(box);
  const int rank = rank_of(comm), size = num_ranks(comm);
  const std::int64_t num_bricks = box.num_cells.prod();
  const auto first = [&](int r) { return static_cast<std::int32_t>(num_bricks * r / size); };
  const auto partition = bisect<dim>(comm, size, brick_centres(box, first(rank), first(rank + 1)));
  return box_part<dim>(
      box, [&](const Vector<dim>& centre) { return partition.rank_of(centre) == rank; });
}

template <int dim>
std::vector<Vector<dim>> cell_centres(const Mesh<dim>& mesh) {
  std::vector<Vector<dim>> centres;
  for (std::int32_t c = 0; c < mesh.num_cells(); ++c) {
    Vector<dim> sum = Vector<dim>::Zero();
    for (const std::int32_t i : mesh.cell(c)) sum += mesh.nodes[i];
    centres.push_back(sum / mesh.nodes_per_cell());
  }
  return centres;
}

template <class Number>
void put_list(Packet& packet, const std::vector<Number>& list) {
  packet.put(static_cast<std::int64_t>(list.size()));
  packet.put_all(std::span<const Number>(list));
}
template <class Number>
std::vector<Number> take_list(Packet& packet) {
  std::vector<Number> list(packet.take<std::int64_t>());
  packet.take_all(list);
  return list;
}

void put_text(Packet& packet, const std::string& text) {
  put_list(packet, std::vector<char>(text.begin(), text.end()));
}
std::string take_text(Packet& packet) {
  const auto text = take_list<char>(packet);
  return {text.begin(), text.end()};
}

template <int dim>
Packet packed(const MeshPart<dim>& part) {
  Packet packet;
  const Mesh<dim>& mesh = part.mesh;
  packet.put(static_cast<std::int32_t>(mesh.cell_type));
  put_text(packet, mesh.file);
  packet.put(std::ssize(mesh.nodes));
  for (const Vector<dim>& x : mesh.nodes) packet.put(x);
  put_list(packet, mesh.cells);
  packet.put(std::ssize(mesh.facet_groups));
  for (const auto& [name, facets] : mesh.facet_groups) {
    put_text(packet, name);
    put_list(packet, facets);
    put_list(packet, part.numbers.facets.at(name));
  }
  packet.put(std::ssize(mesh.cell_groups));
  for (const auto& [name, cells] : mesh.cell_groups) {
    put_text(packet, name);
    put_list(packet, cells);
  }
  put_list(packet, part.numbers.nodes);
  put_list(packet, part.numbers.cells);
  packet.put(part.numbers.num_nodes);
  packet.put(part.numbers.num_cells);
  return packet;
}

template <int dim>
MeshPart<dim> unpacked(Packet packet) {
  MeshPart<dim> part;
  Mesh<dim>& mesh = part.mesh;
  mesh.cell_type = static_cast<CellType>(packet.take<std::int32_t>());
  mesh.file = take_text(packet);
  mesh.nodes.resize(packet.take<std::ptrdiff_t>());
  for (Vector<dim>& x : mesh.nodes) x = packet.take<Vector<dim>>();
  mesh.cells = take_list<std::int32_t>(packet);
  for (auto left = packet.take<std::ptrdiff_t>(); left > 0; --left) {
    const std::string name = take_text(packet);
    mesh.facet_groups[name] = take_list<std::int32_t>(packet);
    part.numbers.facets[name] = take_list<std::int64_t>(packet);
  }
  for (auto left = packet.take<std::ptrdiff_t>(); left > 0; --left) {
    const std::string name = take_text(packet);
    mesh.cell_groups[name] = take_list<std::int32_t>(packet);
  }
  part.numbers.nodes = take_list<std::int32_t>(packet);
  part.numbers.cells = take_list<std::int32_t>(packet);
  part.numbers.num_nodes = packet.take<std::int32_t>();
  part.numbers.num_cells = packet.take<std::int32_t>();
  return part;
}

/// @param whole  on the first rank
template <int dim>
MeshPart<dim> part_of_mesh(const Mesh<dim>& whole, MPI_Comm comm) {
  const int rank = rank_of(comm), size = num_ranks(comm);
  std::vector<Vector<dim>> centres = cell_centres(whole);
  const auto partition = bisect<dim>(comm, size, centres);
  std::vector<int> rank_of_cell;
  for (const Vector<dim>& x : centres) rank_of_cell.push_back(partition.rank_of(x));
  centres = {};
  MeshParts<dim> parts(whole, std::move(rank_of_cell));
  MeshPart<dim> own;
  if (rank == 0) own = parts.take(0);
  for (int other = 1; other < size; ++other) {
    Packets out;
    if (rank == 0) out.emplace(other, packed(parts.take(other)));
    Packets in = send_packets(comm, out);
    if (rank == other) own = unpacked<dim>(std::move(in.at(0)));
  }
  return own;
}

}  // namespace

template <int dim>
RankedMesh<dim> read_mesh_of_rank(const Scene& scene, ConfigReader& fem, MPI_Comm comm) {
  const ConfigReader in = fem.object("mesh");
  const bool one_material = !fem.has("materials");
  RankedMesh<dim> ranked;
  if (num_ranks(comm) == 1) {
    ranked.mesh = read_mesh<dim>(scene, in);
    if (one_material) warn_of_cell_groups(ranked.mesh, fem.where("mesh"));
    if (!ranked.mesh.file.empty()) ranked.connection = connection_of(ranked.mesh);
    return ranked;
  }
  const auto source = read_box_or_file<dim>(in);
  MeshPart<dim> part;
  if (const auto* box = std::get_if<BoxShape<dim>>(&source)) {
    try {
      part = part_of_box(*box, comm);
    } catch (const ConfigError& error) {
      in.fail("box/cells", error.what());
    }
  } else {
    Mesh<dim> whole;
    together<ConfigError>(comm, [&] {
      if (rank_of(comm) != 0) return;
      whole = read_mesh_file<dim>(scene, in, std::get<std::string>(source));
      ranked.connection = connection_of(whole);
    });
    if (one_material) warn_of_cell_groups(whole, fem.where("mesh"));
    part = part_of_mesh(whole, comm);
  }
  ranked.ranks = MeshRanks(comm, std::move(part.numbers), part.mesh.facet_groups);
  ranked.mesh = std::move(part.mesh);
  return ranked;
}

template RankedMesh<2> read_mesh_of_rank(const Scene&, ConfigReader&, MPI_Comm);
template RankedMesh<3> read_mesh_of_rank(const Scene&, ConfigReader&, MPI_Comm);

}  // namespace gabion::fem
