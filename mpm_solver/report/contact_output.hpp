// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/mechanics/output/xdmf_series.hpp"
#include "mpm_solver/contact/contact_fields.hpp"
#include "mpm_solver/step/soil_state.hpp"

namespace gabion::mpm {

/// Contact fields as they are written, an entry a facet.
template <int dim>
struct ContactFrame {
  std::vector<double> pressure;  ///< normal force of the soil over the present area [Pa]
  std::vector<double> shear;     ///< tangential force over it, dim components [Pa]
  std::vector<double> gap;       ///< smallest [m]; NaN where no soil is known
  std::vector<double> slip;      ///< velocity of the soil along the surface, dim components [m/s]
  std::vector<double> status;    ///< 0 open, 1 sticks, 2 slides
};

/// @throws Error  a facet without area
template <int dim>
ContactFrame<dim> contact_frame(const ContactSurface<dim>& surface,
                                const ContactFields<dim>& fields);

/// Frames of each interface and rigid wall where it is, with the fields of ContactFrame on its
/// facets: series contact_NAME, written on the first rank.
template <int dim>
class ContactOutput {
 public:
  /// @param folder  empty: nothing is written
  ContactOutput(const SoilModel<dim>& model, const std::string& folder);
  /// @note Collective.
  void write(double time, const SoilState<dim>& state);
  /// Size of a frame of all surfaces before compression.
  static std::int64_t frame_bytes(const MpmSettings<dim>& settings);

 private:
  const SoilModel<dim>& model_;
  bool writes_;
  std::vector<XdmfSeries> series_;  // of each surface; on the first rank only
};

}  // namespace gabion::mpm
