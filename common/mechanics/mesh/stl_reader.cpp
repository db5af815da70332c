// SPDX-License-Identifier: BSD-3-Clause
// STL: 3D Systems, "StereoLithography Interface Specification" (1988).
#include "common/mechanics/mesh/surface_text.hpp"
#include "common/mechanics/mesh/triangle_surface.hpp"

namespace gabion {

namespace {

constexpr std::size_t header_bytes = 84, triangle_bytes = 50;

template <class Number>
void add_vertex(SurfaceText& in, TriangleSurface& surface) {
  Vector<3> x;
  for (int d = 0; d < 3; ++d) x[d] = in.number<Number>("a coordinate");
  surface.vertices.push_back(x);
}

void add_triangle(TriangleSurface& surface) {
  const auto last = static_cast<std::int32_t>(surface.vertices.size());
  surface.triangles.push_back({last - 3, last - 2, last - 1});
}

// Triangles that a file of bytes announces; what follows does not have to be of bytes.
std::size_t announced(const std::string& text) {
  std::uint32_t count = 0;
  if (text.size() >= header_bytes) std::memcpy(&count, text.data() + 80, sizeof(count));
  return count;
}

TriangleSurface read_stl_bytes(SurfaceText& in) {
  TriangleSurface surface;
  const std::size_t count = announced(in.all());
  in.read_bytes_from(header_bytes);
  for (std::size_t k = 0; k < count; ++k) {
    for (int d = 0; d < 3; ++d) in.number<float>("a normal");
    for (int v = 0; v < 3; ++v) add_vertex<float>(in, surface);
    in.number<std::uint16_t>("an attribute");
    add_triangle(surface);
  }
  return surface;
}

TriangleSurface read_stl_text(SurfaceText& in) {
  TriangleSurface surface;
  in.line("\"solid\"");
  while (true) {
    const std::string_view word = in.word("\"facet\" or \"endsolid\"");
    if (word == "endsolid") return surface;
    if (word != "facet") {
      in.fail(fmt::format("found \"{}\", expected \"facet\" or \"endsolid\"", word.substr(0, 40)));
    }
    in.expect("normal");
    for (int d = 0; d < 3; ++d) in.word("a normal");
    in.expect("outer");
    in.expect("loop");
    for (int v = 0; v < 3; ++v) {
      in.expect("vertex");
      add_vertex<double>(in, surface);
    }
    in.expect("endloop");
    in.expect("endfacet");
    add_triangle(surface);
  }
}

}  // namespace

TriangleSurface read_stl(const std::string& path) {
  SurfaceText in(path);
  const std::string& text = in.all();
  if (text.size() >= header_bytes &&
      text.size() == header_bytes + triangle_bytes * announced(text)) {
    return read_stl_bytes(in);
  }
  if (text.starts_with("solid")) return read_stl_text(in);
  if (text.size() < header_bytes) {
    in.fail(
        fmt::format("found {} bytes, expected an STL file: \"solid\", or {} bytes and triangles",
                    text.size(), header_bytes));
  }
  in.fail(
      fmt::format("found {} bytes, expected {} of the {} triangles that the file announces, or "
                  "a text that begins with \"solid\"",
                  text.size(), header_bytes + triangle_bytes * announced(text), announced(text)));
}

}  // namespace gabion
