// SPDX-License-Identifier: BSD-3-Clause
// PLY: Turk (1994), "The PLY polygon file format".
#include <array>
#include <optional>
#include <utility>

#include "common/mechanics/mesh/surface_text.hpp"
#include "common/mechanics/mesh/triangle_surface.hpp"

namespace gabion {

namespace {

struct Property {
  std::string name;
  std::string type;
  std::string count_type;  // type of the count of a list, else empty
};

struct Element {
  std::string name;
  std::int64_t count = 0;
  std::vector<Property> properties;
};

std::vector<std::string> words_of(std::string_view line) {
  std::istringstream in{std::string(line)};
  std::vector<std::string> words;
  for (std::string word; in >> word;) words.push_back(word);
  return words;
}

double number_of(SurfaceText& in, const std::string& type) {
  const char* what = "a number";
  if (type == "char" || type == "int8") return in.number<std::int8_t>(what);
  if (type == "uchar" || type == "uint8") return in.number<std::uint8_t>(what);
  if (type == "short" || type == "int16") return in.number<std::int16_t>(what);
  if (type == "ushort" || type == "uint16") return in.number<std::uint16_t>(what);
  if (type == "int" || type == "int32") return in.number<std::int32_t>(what);
  if (type == "uint" || type == "uint32") return in.number<std::uint32_t>(what);
  if (type == "float" || type == "float32") return in.number<float>(what);
  if (type == "double" || type == "float64") return in.number<double>(what);
  in.fail(fmt::format("found the type \"{}\", expected one of PLY", type));
}

bool is_integer(const std::string& type) {
  return type.find("int") != std::string::npos || type.find("char") != std::string::npos ||
         type.find("short") != std::string::npos;
}

// Length of a list. Each entry takes a byte at least: a broken length must not cost memory or time.
std::int64_t list_size(SurfaceText& in, const Property& property) {
  const double size = number_of(in, property.count_type);
  if (!(size >= 0 && size <= static_cast<double>(in.bytes_left()))) {
    in.fail(
        fmt::format("found a list \"{}\" of {} numbers, allowed: what the rest of the file holds",
                    property.name, size));
  }
  return static_cast<std::int64_t>(size);
}

std::int64_t count_of(SurfaceText& in, const std::string& word) {
  std::int64_t count = -1;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), count);
  if (error != std::errc{} || end != word.data() + word.size() || count < 0) {
    in.fail(fmt::format("found \"{}\", expected a count", word));
  }
  return count;
}

// An element that takes no byte has no end, and one that the file cannot hold does not begin.
void check(SurfaceText& in, const Element& element) {
  if (element.count == 0) return;
  if (element.properties.empty()) {
    in.fail(fmt::format("found {} of the element \"{}\" without a property, allowed: one at least",
                        element.count, element.name));
  }
  if (std::cmp_greater(element.count, in.bytes_left())) {
    in.fail(fmt::format("found {} of the element \"{}\", more than the rest of the file can hold",
                        element.count, element.name));
  }
  for (const Property& property : element.properties) {
    const std::string& count = property.count_type;
    const bool corners = property.name == "vertex_indices" || property.name == "vertex_index";
    for (const std::string& type :
         {count.empty() ? "int" : count, corners ? property.type : "int"}) {
      if (is_integer(type)) continue;
      in.fail(
          fmt::format("found \"{}\" of the type \"{}\", allowed: whole numbers for counts and "
                      "vertices",
                      property.name, type));
    }
  }
}

// Header up to its end, with the numbers behind it as words or bytes.
std::vector<Element> read_header(SurfaceText& in) {
  if (in.line("\"ply\"") != "ply") in.fail("expected a file that begins with \"ply\"");
  std::vector<Element> elements;
  std::string format;
  while (true) {
    const auto words = words_of(in.line("\"end_header\""));
    if (words.empty() || words[0] == "comment" || words[0] == "obj_info") continue;
    if (words[0] == "end_header") break;
    if (words[0] == "format" && words.size() == 3) {
      format = words[1];
    } else if (words[0] == "element" && words.size() == 3) {
      elements.push_back({words[1], count_of(in, words[2]), {}});
    } else if (words[0] == "property" && words.size() == 3 && !elements.empty()) {
      elements.back().properties.push_back({words[2], words[1], ""});
    } else if (words[0] == "property" && words.size() == 5 && !elements.empty()) {
      elements.back().properties.push_back({words[4], words[3], words[2]});
    } else {
      in.fail(fmt::format("found a line \"{} ...\", expected format, element or property",
                          words[0].substr(0, 40)));
    }
  }
  if (format == "binary_little_endian") {
    in.read_bytes_from(in.all().size() - in.bytes_left());
  } else if (format != "ascii") {
    in.fail(fmt::format("found the format \"{}\", allowed: ascii, binary_little_endian", format));
  }
  for (const Element& element : elements) check(in, element);
  return elements;
}

void add_vertex(SurfaceText& in, const Element& element, TriangleSurface& surface) {
  static const std::array<std::string, 3> axes = {"x", "y", "z"};
  std::array<std::optional<double>, 3> x;
  for (const Property& property : element.properties) {
    if (!property.count_type.empty()) in.fail("found a list in a vertex, expected numbers");
    const double value = number_of(in, property.type);
    for (int d = 0; d < 3; ++d) {
      if (property.name == axes[d]) x[d] = value;
    }
  }
  if (!x[0] || !x[1] || !x[2]) in.fail("found vertices without x, y and z");
  surface.vertices.emplace_back(*x[0], *x[1], *x[2]);
}

void add_face(SurfaceText& in, const Element& element, TriangleSurface& surface) {
  for (const Property& property : element.properties) {
    const bool list = !property.count_type.empty();
    const std::int64_t size = list ? list_size(in, property) : 1;
    const bool corners =
        list && (property.name == "vertex_indices" || property.name == "vertex_index");
    if (corners && size != 3) {
      in.fail(fmt::format("found a face of {} vertices, allowed: triangles", size));
    }
    std::array<std::int32_t, 3> triangle{};
    for (std::int64_t k = 0; k < size; ++k) {
      const double value = number_of(in, property.type);
      if (!corners) continue;
      if (!(value >= 0 && value < static_cast<double>(surface.vertices.size()))) {
        in.fail(fmt::format("found the vertex {}, allowed: 0 to {}", value,
                            static_cast<std::int64_t>(surface.vertices.size()) - 1));
      }
      triangle[k] = static_cast<std::int32_t>(value);
    }
    if (corners) surface.triangles.push_back(triangle);
  }
}

void skip(SurfaceText& in, const Element& element) {
  for (const Property& property : element.properties) {
    const std::int64_t size = property.count_type.empty() ? 1 : list_size(in, property);
    for (std::int64_t k = 0; k < size; ++k) number_of(in, property.type);
  }
}

}  // namespace

TriangleSurface read_ply(const std::string& path) {
  SurfaceText in(path);
  TriangleSurface surface;
  for (const Element& element : read_header(in)) {
    for (std::int64_t k = 0; k < element.count; ++k) {
      if (element.name == "vertex") {
        add_vertex(in, element, surface);
      } else if (element.name == "face") {
        add_face(in, element, surface);
      } else {
        skip(in, element);
      }
    }
  }
  return surface;
}

}  // namespace gabion
