// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "common/run/solver.hpp"
#include "common/run/state.hpp"
#include "coupler/mapping/interface_layout.hpp"
#include "coupler/mapping/mapping.hpp"

namespace gabion {

/// One entry of "interfaces" in coupler.json: two participants that share a surface.
struct InterfaceSettings {
  std::string name;
  std::string soil;
  std::string structure;
  std::vector<double> moment_about = {};  ///< [m], dim numbers; empty: the origin
  std::string where = {};                 ///< its place in coupler.json, for messages
};

/// Force and moment about the origin, in deformed positions.
struct Resultant {
  Eigen::Vector3d force = Eigen::Vector3d::Zero();   ///< [N]
  Eigen::Vector3d moment = Eigen::Vector3d::Zero();  ///< [N m]; 2D: only the third component
};

/// All interfaces of a run. Each side has its values in one vector, one interface after the other:
/// x and f on the structures' vertices, u and f_soil on the soils'.
///
/// A map H that was set up at x_b, where the soil's displacement was u_b, gives the soil
///
///     u = u_b + H (x - x_b)             f = H^T f_soil
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
  Eigen::Index size() const { return size_; }            ///< length of x and f
  Eigen::Index soil_size() const { return soil_size_; }  ///< length of u and f_soil
  /// Ranges of the interfaces of a participant in the vectors of its side.
  InterfaceLayout layout(const std::string& participant) const;

  Eigen::VectorXd soil_displacement(const Eigen::VectorXd& x) const;     ///< u
  Eigen::VectorXd structure_force(const Eigen::VectorXd& f_soil) const;  ///< f
  Resultant soil_resultant(const Eigen::VectorXd& u, const Eigen::VectorXd& f_soil) const;
  Resultant structure_resultant(const Eigen::VectorXd& x, const Eigen::VectorXd& f) const;

  /// Whether both sides of an interface have the same vertices in the same order.
  bool has_same_vertices(const std::string& interface) const;
  /// Refuse an interface with the same vertices whose sides have other facets.
  void require_same_facets(const std::string& interface) const;

  /// Resultants on the structure at each interface, in the order of the settings; moments about its
  /// InterfaceSettings::moment_about, a place in space.
  std::vector<Resultant> structure_resultants(const Eigen::VectorXd& x,
                                              const Eigen::VectorXd& f) const;

  /// Note that x was accepted. With positions "deformed", set up anew the map of each interface of
  /// which a vertex has moved by more than the share `moved` of the structure's extent since the
  /// last set-up.
  void accept(const Eigen::VectorXd& x);
  /// Save or load where the maps were set up.
  void visit_state(StateVisitor& visitor);
  /// MappingReport of each interface's last set-up, and their number, for summary.json.
  Json report() const;

 private:
  struct Interface {
    InterfaceSettings names;
    InterfaceMesh soil_mesh;
    InterfaceMesh structure_mesh;
    Mapping mapping;
    Eigen::Index begin = 0;       // first place in x
    Eigen::Index soil_begin = 0;  // first place in u
    Eigen::VectorXd x_b = {};     // x at the last set-up; empty: reference positions
    Eigen::VectorXd u_b = {};
    double reach = 0;  // [m] that a vertex may move before the next set-up
    int num_set_ups = 1;
  };
  void place_soils();
  void soil_values(const Interface& interface, const Eigen::VectorXd& x, std::span<double> u) const;
  void set_up(Interface& interface) const;

  MappingSettings settings_;
  int dim_ = 0;
  Eigen::Index size_ = 0;
  Eigen::Index soil_size_ = 0;
  std::vector<Interface> interfaces_;
};

}  // namespace gabion
