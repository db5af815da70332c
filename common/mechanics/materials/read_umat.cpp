// SPDX-License-Identifier: BSD-3-Clause
#include "common/mechanics/materials/read_umat.hpp"

#include <fmt/format.h>

#include <filesystem>

#include "common/mechanics/materials/umat_model.hpp"

namespace gabion {

std::vector<Key> umat_keys() {
  const std::vector<std::string> umat = {"umat"};
  const std::size_t most_constants = 1000;
  return {
      key::text(
          "library",
          "Shared library with the subroutine UMAT (symbol umat_, umat or UMAT); it runs with "
          "the rights of the user, as docs/umat.md says.")
          .when("law", umat),
      key::vector("constants", "", "PROPS, in the order that the subroutine asks for.")
          .wide(0, most_constants)
          .or_none()
          .when("law", umat),
      key::vector("initial_variables", "",
                  "STATEV of virgin soil; their number is NSTATV. None: no state variables.")
          .wide(0, most_umat_variables)
          .or_none()
          .when("law", umat),
      key::text("name", "CMNAME, in capitals as Abaqus passes it.").or_none().when("law", umat)};
}

template <int dim>
Material<dim> read_material_in(const std::string& folder, ConfigReader in) {
  if (in.choice("law") != "umat") return read_material<dim>(std::move(in));
  Material<dim> material{.law_name = "umat", .density = in.number("density"), .law = {}};
  UmatSettings settings;
  settings.where = in.where("library");
  settings.where.resize(settings.where.rfind('/'));
  const std::filesystem::path given = in.text("library");
  const std::filesystem::path path = std::filesystem::path(folder) / given;  // given if absolute
  if (!std::filesystem::is_regular_file(path)) {
    in.fail("library",
            fmt::format("found {}, which is no file, allowed: a shared library, its path "
                        "relative to this file",
                        path.string()));
  }
  settings.library = std::filesystem::absolute(path).string();
  settings.constants = in.optional_vector("constants").value_or(std::vector<double>{});
  settings.initial_variables =
      in.optional_vector("initial_variables").value_or(std::vector<double>{});
  if (in.has("name")) settings.name = in.text("name");
  in.finish();
  material.law = Umat<dim>(std::make_shared<const UmatModel>(std::move(settings), dim));
  return material;
}

template Material<2> read_material_in<2>(const std::string&, ConfigReader);
template Material<3> read_material_in<3>(const std::string&, ConfigReader);

}  // namespace gabion
