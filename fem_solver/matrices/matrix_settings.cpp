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
      "A linear structure as matrices over its free unknowns, of any code. Files, relative to the "
      "scene: matrices as Matrix Market, or of CalculiX where their names end in .sti, .mas, .dof.",
      {file_key("stiffness", "K [N/m], symmetric."),
       file_key("mass", "M [kg], symmetric, positive definite; required but in statics.").or_none(),
       file_key("damping", "C [N s/m], symmetric, positive semidefinite.")
           .or_none()
           .without("rayleigh"),
       key::object("rayleigh", rayleigh_keys(), "Damping from K and M.")
           .or_none()
           .without("damping"),
       file_key("load", "Constant nodal forces [N] beside those of the interfaces, n x 1.")
           .or_none(),
       file_key("unknowns",
                "What each row is: rows `node, direction`, 1 to 3 displacement, 4 to 6 "
                "rotation."),
       file_key("held",
                "What does not move, rows `node, direction` or `node` for all of it: taken "
                "out of the matrices if it is in them.")
           .or_none(),
       file_key("nodes",
                "Rows `node, x, y` and z in 3D [m]: of wet surfaces, probes and frames. Each "
                "component of their displacement is an unknown or held."),
       file_key("cells", "Rows of node numbers in the order of Gmsh, for frames; none: the facets.")
           .or_none(),
       key::integer("modes",
                    "Craig-Bampton reduction: unknowns of the wet surfaces and so many "
                    "modes with these held.")
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
