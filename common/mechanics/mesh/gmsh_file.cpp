// SPDX-License-Identifier: BSD-3-Clause
#include "common/mechanics/mesh/gmsh_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <string_view>

#include "common/base/read_file.hpp"
#include "common/base/require.hpp"

namespace gabion {

namespace {

/// Reads numbers one after the other, as text or as bytes, and knows where it is.
class Scanner {
 public:
  Scanner(std::string path, std::string text) : path_(std::move(path)), text_(std::move(text)) {}

  [[noreturn]] void fail(const std::string& message) const {
    throw ConfigError(fmt::format("{}: {}: {}", path_, place(), message));
  }

  bool at_end() {
    skip_space();
    return position_ >= text_.size();
  }

  /// The next characters up to white space.
  std::string_view word(const char* expected) {
    skip_space();
    const std::size_t begin = position_;
    while (position_ < text_.size() && !is_space(text_[position_])) ++position_;
    if (begin == position_) fail(fmt::format("found the end of the file, expected {}", expected));
    return std::string_view(text_).substr(begin, position_ - begin);
  }

  /// A text in double quotes.
  std::string quoted() {
    skip_space();
    const std::size_t end = position_ < text_.size() && text_[position_] == '"'
                                ? text_.find('"', position_ + 1)
                                : std::string::npos;
    if (end == std::string::npos) fail("expected a name in double quotes");
    std::string result = text_.substr(position_ + 1, end - position_ - 1);
    position_ = end + 1;
    return result;
  }

  /// A number as text, whatever the mode of the file.
  template <class T>
  T text_number(const char* expected) {
    const std::string_view found = word(expected);
    T value{};
    const auto [end, error] = std::from_chars(found.data(), found.data() + found.size(), value);
    if (error != std::errc{} || end != found.data() + found.size()) {
      fail(fmt::format("found \"{}\", expected {}", found.substr(0, 40), expected));
    }
    return value;
  }

  template <class T>
  T number(const char* expected) {
    if (!binary_) return text_number<T>(expected);
    if (text_.size() - position_ < sizeof(T)) {
      fail(fmt::format("found the end of the file, expected {}", expected));
    }
    T value;
    std::memcpy(&value, text_.data() + position_, sizeof(T));
    position_ += sizeof(T);
    return value;
  }

  /// A count of things that take at least one byte each in the rest of the file: a broken count
  /// must not reserve memory.
  std::size_t count(const char* expected) {
    const auto value = number<std::uint64_t>(expected);
    if (value > text_.size() - position_) {
      fail(fmt::format("found {} {}, more than the rest of the file can hold", value, expected));
    }
    return value;
  }

  void enter(std::string section, bool binary) {
    section_ = std::move(section);
    binary_ = binary;
    if (binary_ && position_ < text_.size() && text_[position_] == '\r') ++position_;
    if (binary_ && position_ < text_.size() && text_[position_] == '\n') ++position_;
  }

  void leave() {
    binary_ = false;
    const std::string end = "$End" + section_.substr(1);
    const std::string_view found = word(end.c_str());
    if (found != end) fail(fmt::format("found \"{}\", expected {}", found.substr(0, 40), end));
  }

  /// Skip a section that is not needed.
  void skip_section() {
    const std::size_t end = text_.find("\n$End" + section_.substr(1), position_);
    if (end == std::string::npos) fail("found the end of the file, expected the section's end");
    position_ = end;
    leave();
  }

 private:
  static bool is_space(char c) { return c == ' ' || c == '\n' || c == '\r' || c == '\t'; }
  void skip_space() {
    while (position_ < text_.size() && is_space(text_[position_])) ++position_;
  }
  std::string place() const {
    const std::size_t line =
        1 + std::count(text_.begin(), text_.begin() + std::min(position_, text_.size()), '\n');
    const std::string at =
        binary_ ? fmt::format("byte {}", position_) : fmt::format("line {}", line);
    return section_.empty() ? at : fmt::format("{}, section {}", at, section_);
  }

  std::string path_;
  std::string text_;
  std::string section_;
  std::size_t position_ = 0;
  bool binary_ = false;
};

/// @returns whether the file is binary
bool read_format(Scanner& in) {
  if (in.at_end()) in.fail("found an empty file, expected a Gmsh mesh of format 4.1");
  if (in.word("$MeshFormat") != "$MeshFormat") {
    in.fail("expected $MeshFormat: this is no Gmsh mesh file");
  }
  in.enter("$MeshFormat", false);
  const std::string version(in.word("the version"));
  if (version != "4.1") {
    in.fail(
        fmt::format("found format {}, allowed: 4.1; convert with "
                    "`gmsh old.msh -save -format msh41 -o new.msh`",
                    version));
  }
  const int mode = in.text_number<int>("0 (text) or 1 (binary)");
  if (mode != 0 && mode != 1) in.fail(fmt::format("found file type {}, allowed: 0, 1", mode));
  const int size = in.text_number<int>("the size of a count in bytes");
  if (size != 8) in.fail(fmt::format("found data size {}, allowed: 8", size));
  if (mode == 1) {
    in.enter("$MeshFormat", true);
    if (in.number<std::int32_t>("the number 1") != 1) {
      in.fail("found a binary file of the other byte order, allowed: little-endian");
    }
  }
  in.leave();
  return mode == 1;
}

void read_physical_names(Scanner& in, GmshFile& file) {
  const auto n = in.text_number<std::uint64_t>("the number of names");
  for (std::uint64_t i = 0; i < n; ++i) {
    const int dimension = in.text_number<int>("a dimension");
    const int tag = in.text_number<int>("a physical tag");
    file.physical_names[{dimension, tag}] = in.quoted();
  }
}

void read_entities(Scanner& in, GmshFile& file) {
  std::array<std::size_t, 4> counts;
  for (auto& n : counts) n = in.count("entities");
  for (int dimension = 0; dimension < 4; ++dimension) {
    for (std::size_t e = 0; e < counts[dimension]; ++e) {
      const int tag = in.number<std::int32_t>("an entity tag");
      for (int i = 0; i < (dimension == 0 ? 3 : 6); ++i) in.number<double>("a coordinate");
      auto& physical = file.physical_tags[{dimension, tag}];
      const std::size_t num_physical = in.count("physical tags");
      for (std::size_t i = 0; i < num_physical; ++i) {
        const auto group = in.number<std::int32_t>("a physical tag");
        if (group == std::numeric_limits<std::int32_t>::min()) in.fail("found no physical tag");
        physical.push_back(std::abs(group));
      }
      if (dimension == 0) continue;
      const std::size_t num_bounding = in.count("bounding entities");
      for (std::size_t i = 0; i < num_bounding; ++i) in.number<std::int32_t>("an entity tag");
    }
  }
}

void read_nodes(Scanner& in, GmshFile& file) {
  const std::size_t num_blocks = in.count("entity blocks");
  const std::size_t num_nodes = in.count("nodes");
  for (int i = 0; i < 2; ++i) in.number<std::uint64_t>("a node tag");
  for (std::size_t b = 0; b < num_blocks; ++b) {
    const int dimension = in.number<std::int32_t>("a dimension");
    in.number<std::int32_t>("an entity tag");
    const int parametric = in.number<std::int32_t>("0 or 1");
    if (parametric != 0 && parametric != 1) {
      in.fail(fmt::format("found {} for parametric, allowed: 0, 1", parametric));
    }
    const std::size_t n = in.count("nodes");
    for (std::size_t i = 0; i < n; ++i) {
      file.node_tags.push_back(in.number<std::uint64_t>("a node tag"));
    }
    for (std::size_t i = 0; i < n; ++i) {
      auto& x = file.node_positions.emplace_back();
      for (double& value : x) value = in.number<double>("a coordinate");
      if (!std::all_of(x.begin(), x.end(), [](double v) { return std::abs(v) < 1e300; })) {
        in.fail("found a coordinate that is no finite number");
      }
      for (int k = 0; parametric == 1 && k < dimension; ++k) in.number<double>("a parameter");
    }
  }
  if (file.node_tags.size() != num_nodes) {
    in.fail(fmt::format("found {} nodes, the section's head says {}", file.node_tags.size(),
                        num_nodes));
  }
}

void read_elements(Scanner& in, GmshFile& file) {
  const std::size_t num_blocks = in.count("entity blocks");
  const std::size_t num_elements = in.count("elements");
  for (int i = 0; i < 2; ++i) in.number<std::uint64_t>("an element tag");
  std::size_t found = 0;
  for (std::size_t b = 0; b < num_blocks; ++b) {
    GmshFile::ElementBlock block;
    block.dimension = in.number<std::int32_t>("a dimension");
    block.entity = in.number<std::int32_t>("an entity tag");
    block.type = in.number<std::int32_t>("an element type");
    const int n = gmsh_num_nodes(block.type);
    if (n == 0) {
      in.fail(
          fmt::format("found Gmsh's element type {}, allowed: 15 (point), 1 (line), "
                      "2 (triangle), 3 (quad), 4 (tetrahedron), 5 (hexahedron), and of order 2: "
                      "8 (line3), 9 (tri6), 16 (quad8), 10 (quad9), 11 (tet10), 17 (hex20), "
                      "12 (hex27)",
                      block.type));
    }
    const std::size_t count = in.count("elements");
    for (std::size_t e = 0; e < count; ++e) {
      block.tags.push_back(in.number<std::uint64_t>("an element tag"));
      for (int a = 0; a < n; ++a) block.nodes.push_back(in.number<std::uint64_t>("a node tag"));
    }
    found += count;
    file.element_blocks.push_back(std::move(block));
  }
  if (found != num_elements) {
    in.fail(fmt::format("found {} elements, the section's head says {}", found, num_elements));
  }
}

}  // namespace

std::optional<CellType> cell_type_of_gmsh(int type) {
  switch (type) {
    case 15:
      return CellType::point1;
    case 1:
      return CellType::line2;
    case 2:
      return CellType::tri3;
    case 3:
      return CellType::quad4;
    case 4:
      return CellType::tet4;
    case 5:
      return CellType::hex8;
    case 8:
      return CellType::line3;
    case 9:
      return CellType::tri6;
    case 10:
      return CellType::quad9;
    case 11:
      return CellType::tet10;
    case 12:
      return CellType::hex27;
    case 16:
      return CellType::quad8;
    case 17:
      return CellType::hex20;
    default:
      return std::nullopt;
  }
}

int gmsh_num_nodes(int type) {
  const auto known = cell_type_of_gmsh(type);
  return known ? num_nodes(*known) : 0;
}

GmshFile read_gmsh_file(const std::string& path) {
  Scanner in(path, read_file(path, "mesh file"));

  GmshFile file;
  const bool binary = read_format(in);
  bool has_nodes = false, has_elements = false;
  while (!in.at_end()) {
    const std::string section(in.word("a section"));
    if (section[0] != '$' || section.starts_with("$End")) {
      in.fail(fmt::format("found \"{}\", expected the start of a section", section.substr(0, 40)));
    }
    in.enter(section, binary && section != "$PhysicalNames");
    if (section == "$PhysicalNames") {
      read_physical_names(in, file);
    } else if (section == "$Entities") {
      read_entities(in, file);
    } else if (section == "$Nodes") {
      read_nodes(in, file);
      has_nodes = true;
    } else if (section == "$Elements") {
      read_elements(in, file);
      has_elements = true;
    } else if (section == "$PartitionedEntities") {
      in.fail("found a mesh cut into parts, allowed: a mesh in one piece");
    } else {
      in.skip_section();
      continue;
    }
    in.leave();
  }
  in.enter("", false);
  if (!has_nodes) in.fail("found the end of the file, expected a section $Nodes");
  if (!has_elements) in.fail("found the end of the file, expected a section $Elements");
  return file;
}

}  // namespace gabion
