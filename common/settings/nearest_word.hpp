// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

namespace gabion {

/// The candidate with the smallest edit distance to `word`; empty when there is none.
std::string nearest_word(const std::string& word, const std::vector<std::string>& candidates);

}  // namespace gabion
