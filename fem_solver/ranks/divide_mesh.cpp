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
std::vector<Vector<dim>> element_centres(const Mesh<dim>& mesh) {
  std::vector<Vector<dim>> centres;
  for (std::int32_t e = 0; e < mesh.num_elements(); ++e) {
    Vector<dim> sum = Vector<dim>::Zero();
    const auto nodes = mesh.element(e);
    for (const std::int32_t i : nodes) sum += mesh.nodes[i];
    centres.push_back(sum / static_cast<int>(nodes.size()));
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

void put_groups(Packet& packet, const NumberGroups& groups) {
  packet.put(std::ssize(groups));
  for (const auto& [name, members] : groups) {
    put_text(packet, name);
    put_list(packet, members);
  }
}
NumberGroups take_groups(Packet& packet) {
  NumberGroups groups;
  for (auto left = packet.take<std::ptrdiff_t>(); left > 0; --left) {
    const std::string name = take_text(packet);
    groups[name] = take_list<std::int32_t>(packet);
  }
  return groups;
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
  put_list(packet, mesh.lines);
  for (const auto* groups : {&mesh.cell_groups, &mesh.line_groups, &mesh.node_groups}) {
    put_groups(packet, *groups);
  }
  const PartNumbers& numbers = part.numbers;
  for (const auto* list : {&numbers.nodes, &numbers.cells, &numbers.lines}) put_list(packet, *list);
  for (const auto count : {numbers.num_nodes, numbers.num_cells, numbers.num_lines}) {
    packet.put(count);
  }
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
  mesh.lines = take_list<std::int32_t>(packet);
  for (auto* groups : {&mesh.cell_groups, &mesh.line_groups, &mesh.node_groups}) {
    *groups = take_groups(packet);
  }
  PartNumbers& numbers = part.numbers;
  for (auto* list : {&numbers.nodes, &numbers.cells, &numbers.lines}) {
    *list = take_list<std::int32_t>(packet);
  }
  for (auto* count : {&numbers.num_nodes, &numbers.num_cells, &numbers.num_lines}) {
    *count = packet.take<std::int32_t>();
  }
  return part;
}

/// @param whole  on the first rank
template <int dim>
MeshPart<dim> part_of_mesh(const Mesh<dim>& whole, MPI_Comm comm) {
  const int rank = rank_of(comm), size = num_ranks(comm);
  std::vector<Vector<dim>> centres = element_centres(whole);
  const auto partition = bisect<dim>(comm, size, centres);
  std::vector<int> rank_of_element;
  for (const Vector<dim>& x : centres) rank_of_element.push_back(partition.rank_of(x));
  centres = {};
  MeshParts<dim> parts(whole, std::move(rank_of_element));
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

/// The mesh is made as a whole on the first rank, since the numbers of its middle nodes follow from
/// the whole mesh.
template <int dim>
MeshPart<dim> part_of_quadratic_box(const BoxShape<dim>& box, MPI_Comm comm) {
  Mesh<dim> whole;
  together<ConfigError>(comm, [&] {
    if (rank_of(comm) != 0) return;
    whole = box_mesh<dim>(box.low, box.high, box.num_cells, box.cell_type, box.alternate);
  });
  return part_of_mesh(whole, comm);
}

}  // namespace

template <int dim>
RankedMesh<dim> read_mesh_of_rank(const Scene& scene, ConfigReader& fem, MPI_Comm comm,
                                  const std::set<std::string>& lines) {
  const ConfigReader in = fem.object("mesh");
  const bool one_material = !fem.has("materials");
  RankedMesh<dim> ranked;
  if (num_ranks(comm) == 1) {
    ranked.mesh = read_mesh<dim>(scene, in, lines, CellOrders::any);
    if (one_material) warn_of_cell_groups(ranked.mesh, fem.where("mesh"));
    if (!ranked.mesh.file.empty()) ranked.connection = connection_of(ranked.mesh);
    return ranked;
  }
  const auto source = read_box_or_file<dim>(in, CellOrders::any);
  MeshPart<dim> part;
  if (const auto* box = std::get_if<BoxShape<dim>>(&source)) {
    try {
      part = is_quadratic(box->cell_type) ? part_of_quadratic_box(*box, comm)
                                          : part_of_box(*box, comm);
    } catch (const ConfigError& error) {
      in.fail("box/cells", error.what());
    }
  } else {
    Mesh<dim> whole;
    together<ConfigError>(comm, [&] {
      if (rank_of(comm) != 0) return;
      whole = read_mesh_file<dim>(scene, in, std::get<std::string>(source), lines, CellOrders::any);
      ranked.connection = connection_of(whole);
    });
    if (one_material) warn_of_cell_groups(whole, fem.where("mesh"));
    part = part_of_mesh(whole, comm);
  }
  FacetGroups groups = part.mesh.node_groups;
  for (const auto& [name, facets] : part.mesh.facet_groups) groups[name] = facets;
  ranked.ranks = MeshRanks(comm, std::move(part.numbers), groups);
  ranked.mesh = std::move(part.mesh);
  return ranked;
}

template RankedMesh<2> read_mesh_of_rank(const Scene&, ConfigReader&, MPI_Comm,
                                         const std::set<std::string>&);
template RankedMesh<3> read_mesh_of_rank(const Scene&, ConfigReader&, MPI_Comm,
                                         const std::set<std::string>&);

}  // namespace gabion::fem
