// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <utility>

#include "common/base/require.hpp"
#include "common/run/list_lengths.hpp"
#include "mpm_solver/contact/contact_fields.hpp"

namespace gabion::mpm {

template <int dim>
void visit_marks(StateVisitor& visitor, const std::string& prefix, std::size_t num_facets,
                 std::vector<ContactMark<dim>>& marks) {
  constexpr Vector<dim> ContactMark<dim>::*members[] = {
      &ContactMark<dim>::x, &ContactMark<dim>::normal, &ContactMark<dim>::force,
      &ContactMark<dim>::slip};
  std::vector<std::int64_t> facets;
  std::vector<double> values;
  for (const ContactMark<dim>& mark : marks) {
    facets.push_back(2 * std::int64_t{mark.facet} + (mark.sliding ? 1 : 0));
    values.insert(values.end(), {mark.area, mark.gap});
    for (const auto member : members) {
      values.insert(values.end(), (mark.*member).begin(), (mark.*member).end());
    }
  }
  visitor.list(prefix + "mark_facets", facets);
  visitor.list(prefix + "marks", values);
  require_values_each(prefix + "marks", values.size(), facets.size(), 2 + 4 * dim);
  marks.assign(facets.size(), {});
  auto value = values.begin();
  for (std::size_t k = 0; k < facets.size(); ++k) {
    require(facets[k] >= 0 && std::cmp_less(facets[k] / 2, num_facets),
            "saved state: \"{}mark_facets\": found {}, allowed: 0 to {}", prefix, facets[k] / 2,
            static_cast<std::int64_t>(num_facets) - 1);
    marks[k].facet = static_cast<std::int32_t>(facets[k] / 2);
    marks[k].sliding = facets[k] % 2 != 0;
    marks[k].area = *value++;
    marks[k].gap = *value++;
    for (const auto member : members) {
      std::copy_n(value, dim, (marks[k].*member).begin());
      value += dim;
    }
  }
}

template void visit_marks<2>(StateVisitor&, const std::string&, std::size_t,
                             std::vector<ContactMark<2>>&);
template void visit_marks<3>(StateVisitor&, const std::string&, std::size_t,
                             std::vector<ContactMark<3>>&);

}  // namespace gabion::mpm
