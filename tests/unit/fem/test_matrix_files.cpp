// SPDX-License-Identifier: BSD-3-Clause
// Files of matrices: what is read, and what errors say.
#include <gtest/gtest.h>

#include "fem_solver/matrices/matrix_files.hpp"
#include "tests/support/expect_error.hpp"
#include "tests/unit/fem/matrix_scene.hpp"

namespace gabion::test::test_matrix_files {
namespace {

using fem::read_symmetric_matrix;
using fem::read_unknowns;
using fem::SparseMatrix;

const std::string symmetric = "%%MatrixMarket matrix coordinate real symmetric\n";
const std::string general = "%%MatrixMarket matrix coordinate real general\n";

class MatrixFiles : public testing::Test {
 protected:
  std::string write(const std::string& file, const std::string& text) {
    folder_.write(file, text);
    return folder_.path(file);
  }
  Eigen::MatrixXd matrix(const std::string& file, const std::string& text) {
    return read_symmetric_matrix(write(file, text));
  }
  void expect_refused(const std::string& file, const std::string& text,
                      const std::vector<std::string_view>& parts) {
    const std::string path = write(file, text);
    expect_error<ConfigError>([&] { read_symmetric_matrix(path); }, parts);
  }

 private:
  MatrixScene folder_;
};

TEST_F(MatrixFiles, both_storages_of_matrix_market_and_calculix_agree) {
  Eigen::MatrixXd expected(2, 2);
  expected << 4, -1.5, -1.5, 3;
  EXPECT_EQ(matrix("a.mtx", symmetric + "2 2 3\n1 1 4\n2 1 -1.5\n2 2 3\n"), expected);
  EXPECT_EQ(matrix("b.mtx", general + "%\n\n2 2 4\n1 1 4\n2 1 -1.5\n1 2 -15e-1\n2 2 +3\n"),
            expected);
  EXPECT_EQ(matrix("c.sti", "1 1  4.0e+00\n1 2  -1.5\n2 2 3\n"), expected);
  EXPECT_EQ(matrix("d.mas", "1 1 4\n2 1 -1.5\n2 2 3\n"), expected);
}

TEST_F(MatrixFiles, entries_of_one_place_are_summed_and_rounding_is_averaged) {
  EXPECT_EQ(matrix("a.mtx", symmetric + "1 1 2\n1 1 4\n1 1 3\n")(0, 0), 7);
  const Eigen::MatrixXd A =
      matrix("b.mtx", general + "2 2 4\n1 1 4\n2 1 1.0000000001\n1 2 1\n2 2 4\n");
  EXPECT_EQ(A(0, 1), A(1, 0));
  EXPECT_NEAR(A(0, 1), 1.00000000005, 1e-15);
}

TEST_F(MatrixFiles, errors_name_file_line_and_what_is_allowed) {
  expect_refused("a.mtx", general + "2 2 3\n1 1 4\n2 1 -1\n2 2 3\n",
                 {"a.mtx", "not symmetric", "-1 at (2, 1)", "0 at (1, 2)"});
  expect_refused("a.mtx", symmetric + "2 3 1\n1 1 4\n", {"a.mtx:2", "2 rows and 3 columns"});
  expect_refused("a.mtx", symmetric + "2 2 2\n1 1 4\n3 1 1\n",
                 {"a.mtx:4", "found 3 as row", "1 to 2"});
  expect_refused("a.mtx", symmetric + "2 2 2\n1 1 4\n1 2 1\n", {"a.mtx:4", "row >= column"});
  expect_refused("a.mtx", symmetric + "2 2 2\n1 1 4\n2 1 nan\n", {"a.mtx:4", "nan", "finite"});
  expect_refused("a.mtx", symmetric + "2 2 2\n1 1 4\n2 1 1e400\n", {"a.mtx:4", "1e400", "finite"});
  expect_refused("a.mtx", symmetric + "2 2 2\n1 1 4\n2 1\n",
                 {"a.mtx:4", "2 numbers", "allowed: 3"});
  expect_refused("a.mtx", symmetric + "2 2 2\n1 1 4\n", {"a.mtx", "1 entries, allowed: 2"});
  expect_refused("a.mtx", symmetric + "1 1 1\n1 1 4\n1 1 4\n", {"a.mtx:4", "more than the 1"});
  expect_refused("a.mtx", "%%MatrixMarket matrix coordinate complex symmetric\n1 1 1\n1 1 4 0\n",
                 {"a.mtx:1", "complex", "real|integer"});
  expect_refused("a.mtx", "1 1 1\n1 1 4\n", {"a.mtx:1", "%%MatrixMarket"});
  expect_refused("a.mtx", "", {"a.mtx:1", "%%MatrixMarket"});
  expect_refused("a.sti", "1 1 4\n1 2 1\n3 1 1\n", {"a.sti:3", "both triangles"});
  expect_refused("a.sti", "\n", {"a.sti", "no entry"});
  expect_error<ConfigError>([] { read_symmetric_matrix("/nowhere/a.mtx"); },
                            {"/nowhere/a.mtx", "cannot open this file of numbers"});
}

TEST_F(MatrixFiles, unknowns) {
  const auto expected = std::vector<fem::Unknown>{{5, 1}, {12, 3}};
  EXPECT_EQ(read_unknowns(write("a.csv", "node,direction\n5,1\n12,3\n")), expected);
  EXPECT_EQ(read_unknowns(write("a.dof", "5.1\n12.3\n")), expected);
  const auto refused = [&](const std::string& text, const std::vector<std::string_view>& parts) {
    const std::string path = write("a.csv", text);
    expect_error<ConfigError>([&] { read_unknowns(path); }, parts);
  };
  refused("5,1\n5,7\n", {"a.csv:2", "7 as direction", "1 to 6"});
  refused("5,1\n5,2\n5,1\n", {"a.csv:3", "node 5, direction 1 a second time"});
  refused("5,1\n5.5,2\n", {"a.csv:2", "5.5 as node", "whole number"});
  refused("5,1\nx,2\n", {"a.csv:2", "\"x\"", "finite number"});
  refused("5,1,0\n", {"a.csv:1", "3 numbers", "2 (node, direction)"});
}

TEST_F(MatrixFiles, vectors) {
  const std::string array = "%%MatrixMarket matrix array real general\n";
  const Eigen::Vector2d expected(0, -2.5);
  EXPECT_EQ(fem::read_vector(write("f.mtx", array + "2 1\n0\n-2.5\n")), expected);
  EXPECT_EQ(fem::read_vector(write("f.mtx", general + "2 1 1\n2 1 -2.5\n")), expected);
  const std::string path = write("f.mtx", array + "3 1\n0\n-2.5\n");
  expect_error<ConfigError>([&] { fem::read_vector(path); }, {"f.mtx", "2 values, allowed: 3"});
}

TEST_F(MatrixFiles, what_is_written_reads_back_to_the_bit) {
  SparseMatrix A(3, 3);
  for (int i = 0; i < 3; ++i) A.insert(i, i) = 1.0 / (3 + i);
  A.insert(2, 0) = 1e-17 / 3;
  A.insert(0, 2) = 1e-17 / 3;
  A.makeCompressed();
  const std::string path = write("A.mtx", "");
  fem::write_symmetric_matrix(path, A);
  EXPECT_EQ(Eigen::MatrixXd(read_symmetric_matrix(path)), Eigen::MatrixXd(A));
  const Eigen::Vector3d x(1.0 / 3, -1e-300, 0);
  fem::write_vector(path, x);
  EXPECT_EQ(fem::read_vector(path), x);
}

}  // namespace
}  // namespace gabion::test::test_matrix_files
