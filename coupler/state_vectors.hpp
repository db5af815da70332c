// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "common/base/require.hpp"
#include "common/run/state.hpp"

namespace gabion {

/// Save or load a vector of any length.
inline void visit_vector(StateVisitor& visitor, const std::string& name, Eigen::VectorXd& vector) {
  std::vector<double> values(vector.begin(), vector.end());
  visitor.list(name, values);
  vector = Eigen::Map<const Eigen::VectorXd>(values.data(), std::ssize(values));
}

/// Save or load the vectors of a list, one after the other, each of any length.
/// @param resize     makes the list as long as it was when saved
/// @param vector_of  index -> vector
template <class Resize, class VectorOf>
void visit_vectors(StateVisitor& visitor, const std::string& name, std::size_t count,
                   const Resize& resize, const VectorOf& vector_of) {
  std::vector<std::int64_t> sizes;
  std::vector<double> values;
  for (std::size_t k = 0; k < count; ++k) {
    const Eigen::VectorXd& vector = vector_of(k);
    sizes.push_back(vector.size());
    values.insert(values.end(), vector.begin(), vector.end());
  }
  visitor.list(name + ".sizes", sizes);
  visitor.list(name, values);
  resize(sizes.size());
  std::size_t start = 0;
  for (std::size_t k = 0; k < sizes.size(); ++k) {
    require(start + static_cast<std::size_t>(sizes[k]) <= values.size(),
            "saved state: \"" + name + "\" is shorter than its sizes say");
    vector_of(k) = Eigen::Map<const Eigen::VectorXd>(values.data() + start, sizes[k]);
    start += static_cast<std::size_t>(sizes[k]);
  }
}

}  // namespace gabion
