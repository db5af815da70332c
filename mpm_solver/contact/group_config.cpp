// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/contact/group_config.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <utility>

#include "mpm_solver/contact/sticking.hpp"
#include "mpm_solver/grid/group_fields.hpp"

namespace gabion::mpm {

namespace {

std::int32_t place_of(const std::vector<std::string>& names, const std::string& name) {
  const auto found = std::find(names.begin(), names.end(), name);
  return found == names.end() ? -1 : static_cast<std::int32_t>(found - names.begin());
}

void read_groups(ConfigReader& in, const std::vector<std::string>& bodies, BodyGroups& groups) {
  groups.of_body.assign(bodies.size(), -1);
  for (auto& item : in.objects("groups")) {
    const std::string name = item.name("name");
    if (place_of(groups.names, name) >= 0) {
      item.fail("name",
                fmt::format("found \"{}\" a second time, allowed: a name of its own", name));
    }
    for (const std::string& body : item.texts("bodies")) {
      const std::int32_t b = place_of(bodies, body);
      if (b < 0) {
        item.fail("bodies", fmt::format("found \"{}\", allowed: the names of bodies: {}", body,
                                        fmt::join(bodies, ", ")));
      }
      if (groups.of_body[b] >= 0) {
        item.fail("bodies",
                  fmt::format("found \"{}\" a second time, allowed: a body in one group", body));
      }
      groups.of_body[b] = static_cast<std::int32_t>(groups.names.size());
    }
    groups.names.push_back(name);
    item.finish();
  }
  const auto left_out = std::find(groups.of_body.begin(), groups.of_body.end(), -1);
  if (left_out != groups.of_body.end()) {
    in.fail("groups", fmt::format("found no group with the body \"{}\", allowed: each body in one",
                                  bodies[left_out - groups.of_body.begin()]));
  }
  if (std::ssize(groups.names) > most_groups) {
    in.fail("groups",
            fmt::format("found {} groups, allowed: at most {}", groups.names.size(), most_groups));
  }
}

GroupPair read_pair(ConfigReader& item, const BodyGroups& groups) {
  GroupPair pair;
  const auto names = item.texts("groups");
  if (names.size() != 2 || names[0] == names[1]) {
    item.fail("groups", fmt::format("found {} groups, allowed: two that differ", names.size()));
  }
  std::int32_t places[2] = {};
  for (int k = 0; k < 2; ++k) {
    places[k] = place_of(groups.names, names[k]);
    if (places[k] < 0) {
      item.fail("groups", fmt::format("found \"{}\", allowed: the names of groups: {}", names[k],
                                      fmt::join(groups.names, ", ")));
    }
  }
  pair.first = std::min(places[0], places[1]);
  pair.second = std::max(places[0], places[1]);
  pair.mode = item.choice("mode") == "slip" ? ContactMode::slip : ContactMode::contact;
  if (item.has("friction") && pair.mode == ContactMode::slip) {
    item.fail("friction", "allowed only with \"mode\": \"contact\"");
  }
  if (pair.mode == ContactMode::contact) {
    pair.friction = item.optional_number("friction").value_or(sticking);
  }
  pair.penalty_factor = item.number("penalty_factor");
  pair.tangential_factor = item.number("tangential_factor");
  item.finish();
  return pair;
}

void read_pairs(ConfigReader& in, BodyGroups& groups) {
  const auto same = [](const GroupPair& a, const GroupPair& b) {
    return a.first == b.first && a.second == b.second;
  };
  for (auto& item : in.objects("pairs")) {
    const GroupPair pair = read_pair(item, groups);
    if (std::ranges::any_of(groups.pairs, [&](const auto& other) { return same(other, pair); })) {
      item.fail("groups", fmt::format("found {} and {} a second time, allowed: a pair once",
                                      groups.names[pair.first], groups.names[pair.second]));
    }
    groups.pairs.push_back(pair);
  }
  const auto count = static_cast<std::int32_t>(groups.names.size());
  for (std::int32_t a = 0; a < count; ++a) {
    for (std::int32_t b = a + 1; b < count; ++b) {
      const GroupPair wanted{.first = a, .second = b};
      if (std::ranges::any_of(groups.pairs, [&](const auto& p) { return same(p, wanted); }))
        continue;
      in.fail("pairs", fmt::format("found no pair of \"{}\" and \"{}\", allowed: each two groups",
                                   groups.names[a], groups.names[b]));
    }
  }
}

KeyTable group_keys() {
  return {"contact_group",
          "Bodies that share the nodes of the grid, so that they stick to each other.",
          {key::plain_name("Name of the group, unique."),
           key::texts("bodies", "Names of its bodies; each body is in one group.").not_empty()}};
}

KeyTable pair_keys() {
  const GroupPair defaults;
  return {"contact_pair",
          "Contact between the bodies of two groups.",
          {key::texts("groups", "Names of the two groups."),
           key::choice("mode", {"contact", "slip"},
                       "`contact`: pushes, never pulls, and sticks or slides by `friction`; "
                       "`slip`: pushes in normal direction only.")
               .or_else("contact"),
           key::number("friction", "",
                       "Coefficient of friction; none: bodies stick, by a coefficient of 100, so "
                       "that forces do not jump where they part.")
               .in(non_negative())
               .or_none()
               .when("mode", {"contact"}),
           key::number("penalty_factor", "",
                       "Traction at a penetration of one cell size, over the smaller P-wave "
                       "modulus of the two bodies; it grows with the square of the penetration.")
               .in(positive())
               .or_else(defaults.penalty_factor),
           key::number("tangential_factor", "",
                       "Tangential stiffness times the mean cell size over that modulus.")
               .in(positive())
               .or_else(defaults.tangential_factor)}};
}

}  // namespace

KeyTable contact_group_keys() {
  return {"contact_groups",
          "Bodies with nodes of their own, which meet by contact.",
          {key::objects("groups", group_keys(), "All bodies, in two or more groups.").not_empty(2),
           key::objects("pairs", pair_keys(), "Contact between each two groups.").not_empty()}};
}

BodyGroups read_body_groups(ConfigReader& in, const std::vector<std::string>& bodies) {
  BodyGroups groups;
  auto item = in.optional_object("contact_groups");
  if (!item) return groups;
  groups.where = in.where("contact_groups");
  read_groups(*item, bodies, groups);
  read_pairs(*item, groups);
  item->finish();
  return groups;
}

}  // namespace gabion::mpm
