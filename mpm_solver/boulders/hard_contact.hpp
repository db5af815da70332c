// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "common/run/state.hpp"
#include "mpm_solver/boulders/rigid_body.hpp"

namespace gabion::mpm {

/// Law of a boulder's contact with something hard. Two boulders have the smaller coefficients of
/// both, and the stiffnesses in series; walls and terrain have those of the boulder.
struct HardLaw {
  double friction = 0.5;     ///< Coulomb's coefficient
  double restitution = 0.5;  ///< normal speed after over before an impact, in [0, 1]
  double stiffness = 0;      ///< force of a place at a depth d: stiffness d^2 [N/m^2]
  double rolling = 0;        ///< of a sphere or disc: resisting moment over its radius and force
};

/// Vertices of a facet, in 2D the third is -1; its normal points out of what has it.
using HardFacet = std::array<std::int32_t, 3>;

/// A rigid body whose contact points are those of a sphere or ellipsoid about its centre, or the
/// vertices of its surface.
struct HardBody {
  std::string name;
  BodyMass mass;
  double sphere = 0;                     ///< radius, 0: not a sphere [m]
  double radius = 0;                     ///< of a sphere about the centre that holds it [m]
  Vector<3> axes = Vector<3>::Zero();    ///< semi-axes, in 2D the third is 0; 0: no ellipsoid [m]
  std::vector<Vector<3>> vertices = {};  ///< in axes of the body [m]
  std::vector<HardFacet> facets = {};
  HardLaw law = {};

  bool is_ellipsoid() const { return axes[0] > 0; }
  bool is_round() const { return sphere > 0 || is_ellipsoid(); }
};

/// A surface whose vertices move evenly in a step. It is in contact only with bodies that come from
/// the side to which its normals point.
struct Obstacle {
  std::vector<Vector<3>> start = {}, end = {};  ///< [m]
  std::vector<HardFacet> facets = {};
};

/// Memory of one contact point.
struct HardMemory {
  double gap = 0;     ///< at the end of the last substep; what it stores is not lost or made [m]
  double offset = 0;  ///< <= 0, of that gap: how deep a sphere was when it was first seen there [m]
  double closing = 0;  ///< largest speed at which a surface that gives was met [m/s]
  Vector<3> normal = Vector<3>::Zero();
  Vector<3> slip = Vector<3>::Zero();  ///< of the tangential spring [m]
  Vector<3> turn = Vector<3>::Zero();  ///< of the rolling spring [rad]
};
using HardMemories = std::map<std::array<std::int32_t, 3>, std::vector<HardMemory>>;

/// A step of rigid bodies in contact with each other and obstacles (docs/theory/boulders.md): as
/// many substeps of advance() as the contacts ask for. Between two bodies act equal and opposite
/// forces at one place. No substep gains energy, with stored_energy() and the work on the
/// obstacles.
class HardContact {
 public:
  /// @param dim      2: facets are segments in the plane of the first two coordinates
  /// @param gravity  [m/s^2]
  /// @param giving   number of obstacles, the first ones, that move under the force on them, as
  ///                 structures do: there the force depends smoothly on the motion
  HardContact(int dim, std::vector<HardBody> bodies, const Vector<3>& gravity, int giving = 0);

  struct Start {
    std::vector<BodyState> states = {};
    HardMemories memories = {};
  };
  /// Data of a step, during which the obstacles move from their start to their end.
  struct Step {
    double dt = 0;                     ///< [s]
    double gravity_share = 1;          ///< mean over the step, of the gravity
    std::vector<BodyLoad> loads = {};  ///< besides gravity and these contacts, of each body
    std::vector<char> held = {};       ///< of each body: 1 where it does not move
    std::vector<Obstacle> obstacles = {};
  };
  struct End {
    std::vector<BodyState> states = {};
    HardMemories memories = {};
    std::vector<double> works = {};       ///< work of the contacts on each body [J]
    std::vector<double> load_works = {};  ///< work of Step::loads on each body [J]
    std::vector<BodyLoad> loads = {};     ///< mean, of the contacts on each body
    std::vector<std::vector<Vector<3>>> nodal_forces =
        {};  ///< mean, on the vertices of obstacles [N]
    int substeps = 0;
  };
  /// @throws ConvergenceError  a body moves farther than was looked ahead, contacts do not converge
  ///                           or ask for more than 1e5 substeps
  End solve(const Start& start, const Step& step) const;

  /// Whether a body may come into contact with each obstacle in the step.
  std::vector<char> within_reach(const Start& start, const Step& step) const;

  /// The deepest place where a body is inside another one or an obstacle at the start.
  struct Overlap {
    double depth = 0;                  ///< 0: none [m]
    std::int32_t body = 0, other = 0;  ///< bodies, then obstacles
    Vector<3> place = Vector<3>::Zero();
  };
  Overlap deepest_overlap(const std::vector<BodyState>& states,
                          const std::vector<Obstacle>& obstacles) const;

  /// Energy that the springs of the contact points store [J].
  double stored_energy(const HardMemories& memories) const;

  const std::vector<HardBody>& bodies() const { return bodies_; }

 private:
  struct Pair;
  struct Place;
  struct Sums;
  struct Under;
  struct Watched;
  End solve_here(const Start& start, const Step& step) const;
  bool solve_within(double reach, const Start& start, const Step& step, End& end) const;
  bool solve_substep(double h, const HardMemories& memories, const std::vector<Pair>& pairs,
                     Under& under, Sums& sums) const;
  std::vector<double> effect(const Under& under, const Sums& from, const Sums& to) const;
  void add_substep(const Under& under, double share, Sums& sums, End& end) const;
  double look_ahead(const Start& start, const Step& step) const;
  std::vector<Pair> near_pairs(const std::vector<BodyState>& states, const Step& step,
                               double reach) const;
  void add_pairs(std::int32_t a, std::int32_t b, const Under& under, double reach,
                 std::vector<Pair>& pairs) const;
  double substep(const Under& under, std::vector<Watched>& watched, const HardMemories& memories,
                 double remaining) const;
  double stiffness_over_mass(const Place& place, std::int32_t c, double speed, double& now) const;
  std::vector<double> paths(const Under& under) const;
  bool solve_near(double h, const HardMemories& memories, const std::vector<Watched>& watched,
                  Under& under, Sums& sums) const;
  bool locate(const Pair& pair, const Under& under, Place& place) const;
  bool locate_ellipsoid(const Pair& pair, const Under& under, Place& place) const;
  bool is_point(const Pair& pair, const Under& under) const;
  bool point_place(std::span<const Pair> group, const Under& under, const HardMemories& memories,
                   Place& place) const;
  bool sphere_place(const Pair& pair, const Under& under, Place& place) const;
  std::vector<Place> sphere_places(std::span<const Pair> group, const Under& under) const;
  void recall(const Under& under, const std::vector<HardMemory>& known,
              std::vector<Place>& places) const;
  std::vector<Place> places_of(std::span<const Pair> group, const Under& under,
                               const HardMemories& memories) const;
  std::vector<Place> near_places(std::span<const Pair> group, const Under& under,
                                 const HardMemories& memories) const;
  double size_of(const Pair& pair) const;
  /// @param sums  no forces at the start
  void evaluate(const Under& under, const std::vector<Pair>& pairs, const HardMemories& memories,
                Sums& sums) const;
  void add_place(const Under& under, const Place& place, Sums& sums) const;
  bool gives(std::int32_t a, std::int32_t b) const;
  double normal_force(const Under& under, const Place& place, const HardLaw& law,
                      HardMemory& memory) const;
  double tangential_stiffness(std::int32_t a, std::int32_t b, const HardLaw& law) const;
  std::int32_t num_bodies() const { return static_cast<std::int32_t>(bodies_.size()); }

  int dim_;
  std::vector<HardBody> bodies_;
  Vector<3> gravity_;
  int giving_;
  std::vector<double> dampings_;  // of each body on what gives
};

void visit_memories(StateVisitor& visitor, const std::string& name, HardMemories& memories);

}  // namespace gabion::mpm
