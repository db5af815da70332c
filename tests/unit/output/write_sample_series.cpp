// SPDX-License-Identifier: BSD-3-Clause
// Writes the series that check_series.py reads: points that become more, and a quad mesh.
#include <cmath>
#include <cstdio>
#include <exception>

#include "common/mechanics/output/xdmf_series.hpp"

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  try {
    gabion::XdmfSeries points(argv[1], "points");
    for (int frame = 0; frame < 3; ++frame) {
      std::vector<double> x, pressure, stress;
      for (int p = 0; p < 10 + frame; ++p) {
        x.insert(x.end(), {0.1 * p, std::sqrt(2.0) * frame});
        pressure.push_back(p + 100.0 * frame);
        stress.insert(stress.end(), {1.0, 2.0, 3.0, 4.0});  // xx, yy, zz, xy
      }
      points.write(
          {.time = 0.25 * frame,
           .coordinates = x,
           .fields = {{"pressure", 1, pressure}, {"velocity", 2, x}, {"stress", 4, stress}}});
    }
    gabion::XdmfSeries mesh(argv[1], "mesh");
    const std::vector<double> x = {0, 0, 1, 0, 2, 0, 0, 1, 1, 1, 2, 1}, cell_values = {5.0, 6.0};
    const std::vector<std::int32_t> quads = {0, 1, 4, 3, 1, 2, 5, 4};
    mesh.write({.coordinates = x,
                .cell_type = gabion::CellType::quad4,
                .connectivity = quads,
                .fields = {{"displacement", 2, x}, {"damage", 1, cell_values, true}}});
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
  return 0;
}
