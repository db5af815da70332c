// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "common/run/csv_writer.hpp"
#include "element_test/element_stage.hpp"

namespace gabion::element {

/// The table of a test, a row an increment; docs/element_tests.md lists the columns.
class ElementTable {
 public:
  ElementTable(const std::string& path, const MaterialLaw<3>& law);

  void row(const std::string& stage, const ElementState& state, const Effort& effort);

 private:
  bool has_internal_ = false;
  CsvWriter csv_;
};

}  // namespace gabion::element
