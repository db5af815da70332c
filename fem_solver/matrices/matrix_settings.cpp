// SPDX-License-Identifier: BSD-3-Clause
#include "fem_solver/matrices/matrix_settings.hpp"

namespace gabion::fem {

namespace {

Key file_key(const std::string& name, const std::string& sentence) {
  return key::text(name, sentence);
}

}  // namespace

KeyTable matrix_keys() {
  return {
      "matrices",
      "A linear structure as matrices over its free unknowns, from any code. All are files, "
      "relative to the scene; matrices in the format Matrix Market, or of CalculiX if their names "
      "end in .sti, .mas, .dof.",
      {file_key("stiffness", "K [N/m], symmetric."),
       file_key("mass", "M [kg], symmetric, positive definite; required except in statics.")
           .or_none(),
       file_key("damping", "C [N s/m], symmetric, positive semidefinite.")
           .or_none()
           .without("rayleigh"),
       key::object("rayleigh", rayleigh_keys(), "Damping from K and M.")
           .or_none()
           .without("damping"),
       file_key("load", "Constant nodal forces [N] beside those of the interfaces, n x 1.")
           .or_none(),
       file_key("unknowns",
                "Meaning of each row of the matrices: rows `node, direction`, with directions 1 to "
                "3 for displacement, 4 to 6 for rotation."),
       file_key("held",
                "Unknowns that do not move: rows `node, direction`, or `node` for all directions. "
                "They are taken out of the matrices if these have them.")
           .or_none(),
       file_key("nodes",
                "Nodes of wet surfaces, probes and frames: rows `node, x, y`, in 3D also z [m]. "
                "Each component of their displacement is an unknown or held."),
       file_key("cells",
                "Cells for frames: rows of node numbers in the order of Gmsh; none: the facets.")
           .or_none(),
       key::integer("modes",
                    "Craig-Bampton reduction to the unknowns of the wet surfaces and this number "
                    "of modes with these held.")
           .in(at_least(0))
           .or_none()}};
}

namespace {

std::string file_or_none(ConfigReader& in, const char* key) {
  return in.has(key) ? in.text(key) : "";
}

template <int dim>
void read_files(ConfigReader in, MatrixSettings<dim>& s) {
  if (in.has("rayleigh") && in.has("damping")) {
    in.fail("rayleigh", "allowed: either \"rayleigh\" or \"damping\"");
  }
  s.files.stiffness = in.text("stiffness");
  for (const auto& [key, file] : {std::pair{"mass", &s.files.mass},
                                  {"damping", &s.files.damping},
                                  {"load", &s.files.load},
                                  {"held", &s.files.held},
                                  {"cells", &s.files.cells}}) {
    *file = file_or_none(in, key);
  }
  s.files.unknowns = in.text("unknowns");
  s.files.nodes = in.text("nodes");
  s.rayleigh = read_rayleigh(in);  // beside "damping" there is no such key
  if (in.has("modes")) s.modes = in.integer("modes");
  if (s.dynamic && s.files.mass.empty()) {
    in.fail("mass", "missing; needed when \"analysis\" is \"dynamic\"");
  }
  if (!s.dynamic && (in.has("damping") || in.has("rayleigh"))) {
    in.fail(in.has("damping") ? "damping" : "rayleigh",
            "has no meaning when \"analysis\" is \"static\"");
  }
  if (s.modes.value_or(0) > 0 && s.files.mass.empty()) {
    in.fail("modes", "found modes without \"mass\", allowed: 0, or with \"mass\"");
  }
  in.finish();
}

}  // namespace

template <int dim>
MatrixSettings<dim> read_matrix_settings(ConfigReader& in) {
  MatrixSettings<dim> s;
  s.where = in.where("matrices");
  for (const char* key : {"mesh", "material", "mass", "gravity", "supports", "prescribed", "loads",
                          "tractions", "dashpots", "newton", "linear_solver"}) {
    if (in.has(key)) in.fail(key, "has no meaning beside \"matrices\"");
  }
  read_motion<dim>(in, s);
  read_files(in.object("matrices"), s);
  for (auto& item : in.objects("interfaces")) {
    if (item.has("beams")) item.fail("beams", "has no meaning beside \"matrices\"");
    s.interfaces.push_back(read_interface(item, "facets"));
  }
  s.probes = read_probes<dim>(in);
  require_distinct_names(in, "interfaces", s.interfaces);
  if (!s.interfaces.empty()) require_balance_at_end_of_step(in, s.time_integration);
  if (s.modes && s.interfaces.empty()) {
    in.fail("matrices/modes", "found a reduction to wet surfaces, allowed: with \"interfaces\"");
  }
  if (in.has("$schema")) in.text("$schema");
  return s;
}

template MatrixSettings<2> read_matrix_settings<2>(ConfigReader&);
template MatrixSettings<3> read_matrix_settings<3>(ConfigReader&);

}  // namespace gabion::fem
