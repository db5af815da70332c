// SPDX-License-Identifier: BSD-3-Clause
#include "fem_solver/interface/beam_outline.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <map>

#include "common/base/require.hpp"
#include "fem_solver/beams/beam_axes.hpp"

namespace gabion::fem {

namespace {

constexpr double least_cosine = 0.5;  // between sections of neighbours, whose mean a node has
constexpr double least_turned_cosine = 0.9;  // about the beam, without its bend

/// Beams at a node: the one that ends there and the one that begins there.
struct Joint {
  std::int32_t before = -1, after = -1;
};

template <int dim>
const LineMaterial& beam_of_group(const FemSettings<dim>& s, const std::string& group,
                                  const std::string& where) {
  std::vector<std::string> names;
  for (const LineMaterial& material : s.line_materials) {
    if (!material.beam) continue;
    names.push_back(material.group);
    if (material.group != group) continue;
    require<ConfigError>(!material.beam->section.outline.empty(),
                         "{}: found group \"{}\", whose section is \"general\", allowed: sections "
                         "with a shape",
                         where, group);
    return material;
  }
  throw ConfigError(
      fmt::format("{}: found \"{}\", allowed: groups with \"law\" \"beam\": {}", where, group,
                  names.empty() ? "none" : fmt::format("{}", fmt::join(names, ", "))));
}

template <int dim>
std::map<std::int32_t, Joint> joints_of(const FemSettings<dim>& s, const std::string& group,
                                        const std::string& where) {
  require<ConfigError>(s.mesh.line_groups.contains(group),
                       "{}: found group \"{}\", allowed: a group of lines of the mesh", where,
                       group);
  std::map<std::int32_t, Joint> joints;
  for (const std::int32_t l : s.mesh.line_groups.at(group)) {
    const auto ends = s.mesh.line(l);
    for (int end = 0; end < 2; ++end) {
      Joint& joint = joints[ends[end]];
      std::int32_t& own = end == 0 ? joint.after : joint.before;
      require<ConfigError>(
          own < 0,
          "{}: found node {} of group \"{}\", where two beams {}, allowed: beams of one direction "
          "one after the other, without forks; give branches groups of their own",
          where, ends[end], group, end == 0 ? "begin" : "end");
      own = l;
    }
  }
  return joints;
}

/// Axes of a beam in space; those of the plane have the third across it.
template <int dim>
Matrix<3> axes_of(const FemSettings<dim>& s, const LineMaterial& material, std::int32_t l) {
  const auto ends = s.mesh.line(l);
  Vector<3> chord = Vector<3>::Zero();
  chord.template head<dim>() = s.mesh.nodes[ends[1]] - s.mesh.nodes[ends[0]];
  if (dim == 2) {
    const Vector<3> e_1 = chord.normalized();
    Matrix<3> axes;
    axes << e_1, Vector<3>(-e_1[1], e_1[0], 0), Vector<3>(0, 0, 1);
    return axes;
  }
  return beam_axes(*material.beam, chord, material.where);
}

/// Axes 2 and 3 of the section at a node: the mean of those of the beams there, of such length that
/// the sides of the beams stay in place.
template <int dim>
std::array<Vector<3>, 2> section_at(const FemSettings<dim>& s, const LineMaterial& material,
                                    std::int32_t node, const Joint& joint,
                                    const std::string& where) {
  const std::int32_t any = joint.before >= 0 ? joint.before : joint.after;
  const Matrix<3> own = axes_of(s, material, any);
  std::array<Vector<3>, 2> axes = {own.col(1), own.col(2)};
  if (joint.before < 0 || joint.after < 0) return axes;
  const Matrix<3> other = axes_of(s, material, joint.after);
  if (dim == 3) {  // axes chosen by default may jump from one beam to the next
    const auto bend = Eigen::Quaterniond::FromTwoVectors(own.col(0), other.col(0));
    require<ConfigError>(
        (bend * own.col(1)).dot(other.col(1)) > least_turned_cosine,
        "{}: found beams at node {} whose second axes differ by more than 25 degrees about the "
        "beam, allowed: less; give an \"orientation\", or groups of their own",
        where, node);
  }
  for (int k = 0; k < 2; ++k) {
    const Vector<3> mean = (own.col(1 + k) + other.col(1 + k)).normalized();
    const double cosine = mean.dot(own.col(1 + k));
    require<ConfigError>(cosine > least_cosine,
                         "{}: found beams at node {} whose sections differ by a rotation of more "
                         "than 120 degrees, allowed: less; give them groups of their own",
                         where, node);
    axes[k] = mean / cosine;
  }
  return axes;
}

template <int dim>
void add_ends(std::int64_t first, std::int64_t n, bool low, std::vector<std::int64_t>& facets) {
  if (dim == 2) {
    facets.insert(facets.end(), {low ? first + 1 : first, low ? first : first + 1});
    return;
  }
  for (std::int64_t k = 0; 2 * k + 3 < n; ++k) {  // strips of four corners
    std::array<std::int64_t, 4> quad = {first + k, first + k + 1, first + n - 2 - k,
                                        first + n - 1 - k};
    if (low) std::ranges::reverse(quad);
    facets.insert(facets.end(), quad.begin(), quad.end());
  }
}

template <int dim>
void add_sides(std::int64_t a, std::int64_t b, std::int64_t n, std::vector<std::int64_t>& facets) {
  if (dim == 2) {  // vertex 0 on the right of the beam, 1 on its left
    facets.insert(facets.end(), {a, b, b + 1, a + 1});
    return;
  }
  for (std::int64_t k = 0; k < n; ++k) {
    const std::int64_t next = (k + 1) % n;
    facets.insert(facets.end(), {a + k, a + next, b + next, b + k});
  }
}

}  // namespace

template <int dim>
BeamOutline<dim> beam_outline(const FemSettings<dim>& settings,
                              const std::vector<std::string>& groups, const std::string& where) {
  BeamOutline<dim> outline;
  for (const std::string& group : groups) {
    const LineMaterial& material = beam_of_group(settings, group, where);
    const auto joints = joints_of(settings, group, where);
    std::vector<Vector<2>> corners = material.beam->section.outline;
    if (dim == 2) {
      double reach = 0;
      for (const auto& corner : corners) reach = std::max(reach, corner[0]);
      corners = {{-reach, 0}, {reach, 0}};
    }
    const auto n = static_cast<std::int64_t>(corners.size());
    std::map<std::int32_t, std::int64_t> first;
    for (const auto& [node, joint] : joints) {
      first[node] = static_cast<std::int64_t>(outline.nodes.size());
      const auto axes = section_at(settings, material, node, joint, where);
      for (const Vector<2>& corner : corners) {
        const Vector<3> offset = corner[0] * axes[0] + corner[1] * axes[1];
        outline.nodes.push_back(node);
        outline.offsets.push_back(offset.template head<dim>());
      }
    }
    for (const std::int32_t l : settings.mesh.line_groups.at(group)) {
      const auto ends = settings.mesh.line(l);
      add_sides<dim>(first.at(ends[0]), first.at(ends[1]), n, outline.facets);
    }
    for (const auto& [node, joint] : joints) {
      if (joint.before < 0) add_ends<dim>(first.at(node), n, true, outline.facets);
      if (joint.after < 0) add_ends<dim>(first.at(node), n, false, outline.facets);
    }
  }
  return outline;
}

template BeamOutline<2> beam_outline(const FemSettings<2>&, const std::vector<std::string>&,
                                     const std::string&);
template BeamOutline<3> beam_outline(const FemSettings<3>&, const std::vector<std::string>&,
                                     const std::string&);

}  // namespace gabion::fem
