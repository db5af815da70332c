// SPDX-License-Identifier: BSD-3-Clause
// Files of HDF5 that another hand wrote: rank, type and size are checked before anything is read.
#include <sys/stat.h>

#include <cstring>
#include <fstream>
#include <functional>
#include <vector>

#include "common/hdf5/hdf5_file.hpp"
#include "common/hdf5/hdf5_reader.hpp"
#include "tests/unit/output/output_folder.hpp"

namespace gabion::test_hdf5_reader {
namespace {

using test::expect_error;

class Hdf5ReaderTest : public test::OutputFolder {
 protected:
  /// A file with one dataset "d" that `make` writes with the space and type; both may be closed.
  std::string file_with(const std::vector<hsize_t>& extents, hid_t type,
                        const std::function<void(hid_t)>& write = {},
                        hid_t creation = H5P_DEFAULT) {
    const std::string name = path("made_" + std::to_string(count_++) + ".h5");
    const hid_t file = H5Fcreate(name.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT);
    const hid_t space = extents.empty() ? H5Screate(H5S_SCALAR)
                                        : H5Screate_simple(static_cast<int>(extents.size()),
                                                           extents.data(), nullptr);
    const hid_t data = H5Dcreate2(file, "d", type, space, H5P_DEFAULT, creation, H5P_DEFAULT);
    EXPECT_GE(data, 0);
    if (write) write(data);
    H5Dclose(data);
    H5Sclose(space);
    H5Fclose(file);
    return name;
  }
  static hid_t text_type(std::size_t size) {
    const hid_t type = H5Tcopy(H5T_C_S1);
    H5Tset_size(type, size);
    return type;
  }

 private:
  int count_ = 0;
};

TEST_F(Hdf5ReaderTest, a_text_is_one_and_has_an_end) {
  const auto refused = [](const std::string& file, std::string_view why) {
    expect_error<Error>([&] { Hdf5Reader(file).text("d"); }, {file, "dataset d", why});
  };
  const std::vector<char> many(200000 * 16, 'x');
  refused(file_with({200000}, text_type(16),
                    [&](hid_t data) {
                      H5Dwrite(data, text_type(16), H5S_ALL, H5S_ALL, H5P_DEFAULT, many.data());
                    }),
          "not one text");
  refused(file_with({0}, text_type(16)), "not one text");
  refused(file_with({}, text_type(H5T_VARIABLE),
                    [](hid_t data) {
                      const char* text = "{}";
                      H5Dwrite(data, text_type(H5T_VARIABLE), H5S_ALL, H5S_ALL, H5P_DEFAULT, &text);
                    }),
          "not one text");
  refused(file_with({}, H5T_NATIVE_DOUBLE), "not one text");
  refused(file_with({}, text_type(4),
                    [](hid_t data) {
                      H5Dwrite(data, text_type(4), H5S_ALL, H5S_ALL, H5P_DEFAULT, "abcd");
                    }),
          "without an end");
  refused(file_with({}, text_type(std::size_t{1} << 31)), "damaged");
  const std::string good = file_with({}, text_type(4), [](hid_t data) {
    H5Dwrite(data, text_type(4), H5S_ALL, H5S_ALL, H5P_DEFAULT, "abc");
  });
  EXPECT_EQ(Hdf5Reader(good).text("d"), "abc");
}

TEST_F(Hdf5ReaderTest, nothing_is_allocated_for_values_that_the_file_does_not_hold) {
  const std::string sparse = file_with({hsize_t{1} << 40}, H5T_NATIVE_DOUBLE);
  expect_error<Error>([&] { Hdf5Reader(sparse).reals("d"); }, {sparse, "dataset d", "damaged"});
  const std::string wide = file_with({hsize_t{1} << 31, hsize_t{1} << 31}, H5T_NATIVE_CHAR);
  expect_error<Error>([&] { Hdf5Reader(wide).integers("d"); }, {wide, "allowed: what a file"});
  // The values that compress best are read.
  Hdf5File file(path("zeros.h5"));
  file.write("d", 1, std::vector<double>(3000000));
  file.finish();
  EXPECT_EQ(Hdf5Reader(path("zeros.h5")).reals("d").size(), 3000000U);
  EXPECT_TRUE(Hdf5Reader(file_with({0}, H5T_NATIVE_DOUBLE)).reals("d").empty());
}

TEST_F(Hdf5ReaderTest, types_whose_values_do_not_fit_are_refused) {
  const auto refused = [](const std::string& file, const std::string& found) {
    const Hdf5Reader reader(file);
    expect_error<Error>([&] { reader.integers("d"); },
                        {"dataset d: found " + found, "allowed: integers of at most 8 bytes"});
    expect_error<Error>([&] { reader.reals("d"); },
                        {"dataset d: found " + found, "allowed: floating-point numbers of at"});
    expect_error<Error>([&] { reader.numbers("d"); }, {"dataset d: found " + found, "allowed: "});
  };
  refused(file_with({3}, H5T_NATIVE_UINT64), "integers without a sign of 8 bytes");
  refused(file_with({3}, H5T_NATIVE_LDOUBLE), "floating-point numbers of 16 bytes");
  refused(file_with({3}, text_type(8)), "texts");
  const std::int32_t values[] = {-1, 0, 7};
  const std::string narrow = file_with({3}, H5T_NATIVE_INT32, [&](hid_t data) {
    H5Dwrite(data, H5T_NATIVE_INT32, H5S_ALL, H5S_ALL, H5P_DEFAULT, values);
  });
  EXPECT_EQ(Hdf5Reader(narrow).integers("d"), (std::vector<std::int64_t>{-1, 0, 7}));
  EXPECT_EQ(Hdf5Reader(narrow).numbers("d"), (std::vector<double>{-1, 0, 7}));
  expect_error<Error>([&] { Hdf5Reader(narrow).reals("d"); },
                      {"dataset d: found integers of 4 bytes, allowed: floating-point"});
  Hdf5File file(path("reals.h5"));
  file.write("d", 1, std::vector<float>{0.5F, -2});
  file.finish();
  EXPECT_EQ(Hdf5Reader(path("reals.h5")).numbers("d"), (std::vector<double>{0.5, -2}));
  expect_error<Error>([&] { Hdf5Reader(path("reals.h5")).numbers("e"); }, {"reals.h5", "read e"});
}

TEST_F(Hdf5ReaderTest, ranges_stay_within_the_values) {
  Hdf5File file(path("a.h5"));
  file.write("d", 1, std::vector<double>{1, 2, 3});
  file.finish();
  const Hdf5Reader reader(path("a.h5"));
  EXPECT_EQ(reader.reals("d", {1, 2}), (std::vector<double>{2, 3}));
  constexpr auto largest = std::numeric_limits<std::int64_t>::max();
  for (const ValueRange& range : std::vector<ValueRange>{
           {2, 2}, {-1, 1}, {0, -1}, {largest, largest}, {1, largest}, {largest, 1}}) {
    expect_error<Error>([&] { reader.reals("d", range); }, {"found 3 values"});
  }
}

TEST_F(Hdf5ReaderTest, values_of_other_files_are_refused) {
  std::ofstream(path("secret")) << "12345678";
  const hid_t creation = H5Pcreate(H5P_DATASET_CREATE);
  H5Pset_external(creation, path("secret").c_str(), 0, 8);
  const std::string file = file_with({1}, H5T_NATIVE_INT64, {}, creation);
  H5Pclose(creation);
  expect_error<Error>([&] { Hdf5Reader(file).integers("d"); },
                      {"dataset d: found values that another file holds"});
}

TEST_F(Hdf5ReaderTest, pipes_and_folders_are_no_files) {
  ASSERT_EQ(mkfifo(path("pipe").c_str(), 0600), 0);
  expect_error<ConfigError>([&] { Hdf5Reader{path("pipe")}; }, {path("pipe"), "found a pipe"});
  expect_error<ConfigError>([&] { Hdf5Reader{folder_.string()}; }, {"found a folder"});
  expect_error<ConfigError>([&] { Hdf5Reader{"/dev/zero"}; }, {"found a device"});
  expect_error<ConfigError>([&] { Hdf5Reader{path("none")}; }, {path("none"), "No such file"});
}

}  // namespace
}  // namespace gabion::test_hdf5_reader
