// SPDX-License-Identifier: BSD-3-Clause
#include "fem_solver/fem_config.hpp"

namespace gabion::fem {

KeyTable section_keys() {
  return {
      "section",
      "A plane through the structure before loading. The force and moment between the parts of the "
      "structure there are reported.",
      {key::plain_name("Unique name; columns of the tables start with it."),
       key::vector("point", "m", "Point of the plane, about which moments are given."),
       key::vector("normal", "",
                   "Normal of the plane, of any length; the normal force is along it, tension "
                   "positive.")}};
}

template <int dim>
std::vector<SectionSettings<dim>> read_sections(ConfigReader& in) {
  std::vector<SectionSettings<dim>> sections;
  for (auto& item : in.objects("sections")) {
    SectionSettings<dim> s;
    s.name = item.name("name");
    s.point = Eigen::Map<const Vector<dim>>(item.vector("point", dim).data());
    s.normal = Eigen::Map<const Vector<dim>>(item.vector("normal", dim).data());
    s.where = item.where("point");
    if (!(s.normal.norm() > 0)) item.fail("normal", "found length 0, allowed: > 0");
    s.normal.normalize();
    item.finish();
    sections.push_back(std::move(s));
  }
  require_distinct_names(in, "sections", sections);
  return sections;
}

template std::vector<SectionSettings<2>> read_sections(ConfigReader&);
template std::vector<SectionSettings<3>> read_sections(ConfigReader&);

}  // namespace gabion::fem
