// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <map>
#include <string>
#include <vector>

#include "common/run/solver.hpp"
#include "common/run/state.hpp"
#include "coupler/mapping/mapping.hpp"

namespace gabion {

/// One entry of "interfaces" in coupler.json: two participants that share a surface.
struct InterfaceSettings {
  std::string name;
  std::string soil;
  std::string structure;
};

/// Force and moment about the origin, in deformed positions.
struct Resultant {
  Eigen::Vector3d force = Eigen::Vector3d::Zero();   ///< [N]
  Eigen::Vector3d moment = Eigen::Vector3d::Zero();  ///< [N m]; 2D: only the third component
};

/// All interfaces of a run. The displacement of the structures' wet surfaces, one interface after
/// the other, is one vector x; the force on them is a vector of the same layout.
///
/// A map H that was set up at x_b, where the soil's displacement was u_b, gives the soil
///
///     u = u_b + H (x - x_b)
///
/// so that u does not jump when H changes, and H^T is conservative for the work of each step. In
/// reference positions x_b = 0, u_b = 0.
class InterfaceMap {
 public:
  /// @param meshes  of each participant, as its interfaces() gives them
  /// @throws ConfigError  an interface that a participant does not have, a participant's interface
  ///                      that is not coupled, unequal dimensions, surfaces that do not match
  InterfaceMap(const std::vector<InterfaceSettings>& interfaces,
               const std::map<std::string, std::vector<InterfaceMesh>>& meshes,
               const MappingSettings& settings);

  int dim() const { return dim_; }
  Eigen::Index size() const { return size_; }  ///< of x

  /// MappingReport of each interface's last set-up, and their number, for summary.json.
  Json report() const;

  /// x was accepted. With positions "deformed": set up again the maps of the interfaces that have a
  /// vertex which has moved by more than the share `moved` of the structure's extent since the last
  /// set-up.
  void accept(const Eigen::VectorXd& x);
  /// Save or load where the maps were set up.
  void visit_state(StateVisitor& visitor);

  /// u for the interfaces of one soil.
  InterfaceValues soil_displacement(const std::string& soil, const Eigen::VectorXd& x) const;
  /// force += H^T (what this soil sent). @throws Error  an interface is missing or has another size
  void add_soil_force(const std::string& soil, const InterfaceValues& sent,
                      Eigen::VectorXd& force) const;
  /// The part of a vector that belongs to one structure.
  InterfaceValues structure_values(const std::string& structure, const Eigen::VectorXd& all) const;
  /// Put what a structure sent in its place. @throws Error  as above
  void put_structure_values(const std::string& structure, const InterfaceValues& sent,
                            Eigen::VectorXd& all) const;

  /// @param displacement, force  of one soil's interfaces
  Resultant soil_resultant(const std::string& soil, const InterfaceValues& displacement,
                           const InterfaceValues& force) const;
  Resultant structure_resultant(const Eigen::VectorXd& x, const Eigen::VectorXd& force) const;

 private:
  struct Interface {
    InterfaceSettings names;
    InterfaceMesh soil_mesh;
    InterfaceMesh structure_mesh;
    Mapping mapping;
    Eigen::Index offset;  // in x
    Eigen::Index size;
    Eigen::VectorXd x_b;  // of this interface; empty: reference positions
    Eigen::VectorXd u_b;
    double reach = 0;  // [m] that a vertex may move before the next set-up
    int num_set_ups = 1;
  };
  std::vector<double> soil_values(const Interface& interface, const Eigen::VectorXd& x) const;
  void set_up(Interface& interface) const;

  MappingSettings settings_;
  int dim_ = 0;
  Eigen::Index size_ = 0;
  std::vector<Interface> interfaces_;
};

}  // namespace gabion
