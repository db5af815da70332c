// SPDX-License-Identifier: BSD-3-Clause
#include "fem_solver/matrices/matrix_files.hpp"

#include <fmt/format.h>
#include <fmt/os.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <sstream>

#include "common/base/require.hpp"
#include "fem_solver/matrices/number_lines.hpp"

namespace gabion::fem {

namespace {

using Triplets = std::vector<Eigen::Triplet<double>>;
constexpr std::int64_t largest_index = 2147483646;

/// First line of a Matrix Market file: %%MatrixMarket matrix coordinate real symmetric
struct MarketHeader {
  bool coordinate = false;
  bool symmetric = false;
};

MarketHeader read_header(NumberLines& lines) {
  std::string line(lines.raw_line());
  std::transform(line.begin(), line.end(), line.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  std::istringstream in(line);
  std::string banner, object, form, field, symmetry;
  in >> banner >> object >> form >> field >> symmetry;
  const bool good = banner == "%%matrixmarket" && object == "matrix" &&
                    (form == "coordinate" || form == "array") &&
                    (field == "real" || field == "integer" || field == "double") &&
                    (symmetry == "symmetric" || symmetry == "general");
  if (!good) {
    lines.fail(
        fmt::format("found \"{}\", allowed: %%MatrixMarket matrix coordinate|array "
                    "real|integer symmetric|general",
                    line.substr(0, 80)));
  }
  return {.coordinate = form == "coordinate", .symmetric = symmetry == "symmetric"};
}

/// Rows "row column value"; `size` 0: as large as the largest index.
struct Entries {
  Triplets triplets;
  std::int64_t size = 0;
};

void add_pair(Triplets& triplets, std::int64_t row, std::int64_t column, double value) {
  const int i = static_cast<int>(row - 1), j = static_cast<int>(column - 1);
  triplets.emplace_back(i, j, value);
  if (i != j) triplets.emplace_back(j, i, value);
}

Entries read_calculix(NumberLines& lines) {
  Entries entries;
  const char* meaning = "row, column, value";
  bool upper = false, lower = false;
  for (auto row = lines.next(3, meaning); !row.empty(); row = lines.next(3, meaning)) {
    const auto i = lines.whole(row[0], 1, largest_index, "row");
    const auto j = lines.whole(row[1], 1, largest_index, "column");
    upper = upper || i < j;
    lower = lower || i > j;
    if (upper && lower) lines.fail("found entries of both triangles, allowed: of one");
    add_pair(entries.triplets, i, j, row[2]);
    entries.size = std::max({entries.size, i, j});
  }
  require<ConfigError>(entries.size > 0, "{}: found no entry, allowed: at least one", lines.path());
  return entries;
}

Entries read_market(NumberLines& lines) {
  const MarketHeader header = read_header(lines);
  if (!header.coordinate) lines.fail("found an array, allowed: coordinate");
  const auto sizes = lines.next(3, "rows, columns, entries");
  if (sizes.empty()) lines.fail("found the end, allowed: rows, columns, entries");
  Entries entries;
  entries.size = lines.whole(sizes[0], 1, largest_index, "number of rows");
  if (sizes[1] != sizes[0]) {
    lines.fail(fmt::format("found {} rows and {} columns, allowed: as many", sizes[0], sizes[1]));
  }
  const auto count = lines.whole(sizes[2], 0, std::int64_t{1} << 40, "number of entries");
  for (std::int64_t k = 0; k < count; ++k) {
    const auto row = lines.next(3, "row, column, value");
    if (row.empty()) lines.fail(fmt::format("found {} entries, allowed: {} as said", k, count));
    const auto i = lines.whole(row[0], 1, entries.size, "row");
    const auto j = lines.whole(row[1], 1, entries.size, "column");
    if (header.symmetric && j > i) {
      lines.fail(
          fmt::format("found row {}, column {}, allowed: row >= column of a symmetric one", i, j));
    }
    if (header.symmetric) {
      add_pair(entries.triplets, i, j, row[2]);
    } else {
      entries.triplets.emplace_back(static_cast<int>(i - 1), static_cast<int>(j - 1), row[2]);
    }
  }
  if (!lines.next().empty()) lines.fail(fmt::format("found more than the {} entries said", count));
  return entries;
}

/// @throws ConfigError  the worst pair of entries that differ
void require_symmetric(const SparseMatrix& A, const std::string& path) {
  const SparseMatrix transposed = A.transpose();
  const SparseMatrix difference = A - transposed;
  const Eigen::VectorXd diagonal = A.diagonal().cwiseAbs();
  constexpr double tolerance = 1e-9;
  double worst = tolerance;
  int row = -1, column = -1;
  for (int j = 0; j < difference.outerSize(); ++j) {
    for (SparseMatrix::InnerIterator entry(difference, j); entry; ++entry) {
      if (entry.value() == 0) continue;
      const double scale = std::sqrt(diagonal[entry.row()] * diagonal[j]);
      const double error = scale > 0 ? std::abs(entry.value()) / scale : 1;
      if (error <= worst) continue;
      worst = error;
      row = static_cast<int>(entry.row());
      column = j;
    }
  }
  require<ConfigError>(
      row < 0, "{}: not symmetric: found {} at ({}, {}) and {} at ({}, {}), allowed: equal to {}",
      path, A.coeff(row < 0 ? 0 : row, std::max(column, 0)), row + 1, column + 1,
      A.coeff(std::max(column, 0), row < 0 ? 0 : row), column + 1, row + 1, tolerance);
}

bool ends_with(const std::string& path, const std::vector<std::string>& endings) {
  return std::any_of(endings.begin(), endings.end(),
                     [&](const std::string& ending) { return path.ends_with(ending); });
}

}  // namespace

SparseMatrix read_symmetric_matrix(const std::string& path) {
  NumberLines lines(path);
  const Entries entries =
      ends_with(path, {".sti", ".mas"}) ? read_calculix(lines) : read_market(lines);
  const int n = static_cast<int>(entries.size);
  SparseMatrix A(n, n);
  A.setFromTriplets(entries.triplets.begin(), entries.triplets.end());
  require_symmetric(A, path);
  const SparseMatrix transposed = A.transpose();
  SparseMatrix mean = 0.5 * (A + transposed);
  mean.makeCompressed();
  return mean;
}

Eigen::VectorXd read_vector(const std::string& path) {
  NumberLines lines(path);
  const MarketHeader header = read_header(lines);
  const auto sizes = lines.next(header.coordinate ? 3 : 2, "rows, columns and so on");
  if (sizes.empty()) lines.fail("found the end, allowed: the number of rows and columns");
  const auto size = lines.whole(sizes[0], 1, largest_index, "number of rows");
  lines.whole(sizes[1], 1, 1, "number of columns");
  const auto count = header.coordinate ? lines.whole(sizes[2], 0, size, "number of entries") : size;
  Eigen::VectorXd x = Eigen::VectorXd::Zero(size);
  for (std::int64_t k = 0; k < count; ++k) {
    const auto row =
        header.coordinate ? lines.next(3, "row, column, value") : lines.next(1, "value");
    if (row.empty()) lines.fail(fmt::format("found {} values, allowed: {}", k, count));
    if (header.coordinate) lines.whole(row[1], 1, 1, "column");
    x[header.coordinate ? lines.whole(row[0], 1, size, "row") - 1 : k] += row.back();
  }
  if (!lines.next().empty()) lines.fail(fmt::format("found more than {} values", count));
  return x;
}

std::vector<Unknown> read_unknowns(const std::string& path) {
  NumberLines lines(path, ends_with(path, {".dof"}) ? "." : "");
  std::vector<Unknown> unknowns;
  std::map<std::pair<std::int64_t, int>, std::size_t> seen;
  const char* meaning = "node, direction";
  for (auto row = lines.next(2, meaning); !row.empty(); row = lines.next(2, meaning)) {
    const Unknown unknown = {lines.whole(row[0], 1, largest_index, "node"),
                             static_cast<int>(lines.whole(row[1], 1, 6, "direction"))};
    if (!seen.emplace(std::pair(unknown.node, unknown.direction), unknowns.size()).second) {
      lines.fail(fmt::format("found {} a second time, allowed: once", name(unknown)));
    }
    unknowns.push_back(unknown);
  }
  return unknowns;
}

std::vector<Unknown> read_held(const std::string& path) {
  NumberLines lines(path);
  std::vector<Unknown> held;
  for (auto row = lines.next(); !row.empty(); row = lines.next()) {
    if (row.size() > 2) lines.fail(fmt::format("found {} numbers, allowed: 1 or 2", row.size()));
    const auto node = lines.whole(row[0], 1, largest_index, "node");
    const bool all = row.size() == 1;
    const auto first = all ? 1 : lines.whole(row[1], 1, 6, "direction");
    const auto last = all ? 6 : first;
    for (auto d = first; d <= last; ++d) held.push_back({node, static_cast<int>(d)});
  }
  return held;
}

void write_symmetric_matrix(const std::string& path, const SparseMatrix& A) {
  const SparseMatrix lower = A.triangularView<Eigen::Lower>();
  try {
    auto out = fmt::output_file(path);
    out.print("%%MatrixMarket matrix coordinate real symmetric\n{} {} {}\n", A.rows(), A.cols(),
              lower.nonZeros());
    for (int j = 0; j < lower.outerSize(); ++j) {
      for (SparseMatrix::InnerIterator entry(lower, j); entry; ++entry) {
        out.print("{} {} {}\n", entry.row() + 1, j + 1, entry.value());
      }
    }
    out.close();
  } catch (const std::system_error& error) {
    throw Error(fmt::format("{}: {}", path, error.what()));
  }
}

void write_vector(const std::string& path, const Eigen::VectorXd& x) {
  try {
    auto out = fmt::output_file(path);
    out.print("%%MatrixMarket matrix array real general\n{} 1\n", x.size());
    for (const double value : x) out.print("{}\n", value);
    out.close();
  } catch (const std::system_error& error) {
    throw Error(fmt::format("{}: {}", path, error.what()));
  }
}

}  // namespace gabion::fem
