// SPDX-License-Identifier: BSD-3-Clause
#include "common/hdf5/hdf5_dataset.hpp"

#include <algorithm>

#include "common/hdf5/array_file.hpp"

namespace gabion {

hsize_t chunk_rows_of(const DatasetSize& size, std::size_t value_size) {
  if (size.rows * size.columns * value_size < ArrayFile::smallest_compressed) return 0;
  return std::min<hsize_t>(size.rows, ArrayFile::chunk_rows);
}

hid_t new_dataset(hid_t file, const std::string& name, hid_t type, const DatasetSize& size) {
  const hsize_t extents[2] = {size.rows, size.columns};
  const Handle space(H5Screate_simple(size.rank(), extents, nullptr), H5Sclose);
  const Handle links(H5Pcreate(H5P_LINK_CREATE), H5Pclose);
  const Handle creation(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
  if (space.id() < 0 || links.id() < 0 || creation.id() < 0) return -1;
  bool good = H5Pset_create_intermediate_group(links.id(), 1) >= 0 &&
              H5Pset_obj_track_times(creation.id(), false) >= 0;  // equal runs, equal files
  const hsize_t rows = chunk_rows_of(size, H5Tget_size(type));
  if (rows > 0) {
    const hsize_t chunk[2] = {rows, size.columns};
    good = good && H5Pset_chunk(creation.id(), size.rank(), chunk) >= 0 &&
           H5Pset_shuffle(creation.id()) >= 0 && H5Pset_deflate(creation.id(), 1) >= 0;
  }
  if (!good) return -1;
  return H5Dcreate2(file, name.c_str(), type, space.id(), links.id(), creation.id(), H5P_DEFAULT);
}

hid_t new_text(hid_t file, const std::string& name, std::size_t length) {
  const Handle space(H5Screate(H5S_SCALAR), H5Sclose);
  const Handle type(H5Tcopy(H5T_C_S1), H5Tclose);
  const Handle creation(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
  const bool good = space.id() >= 0 && type.id() >= 0 && creation.id() >= 0 &&
                    H5Tset_size(type.id(), length + 1) >= 0 &&
                    H5Pset_obj_track_times(creation.id(), false) >= 0;
  if (!good) return -1;
  return H5Dcreate2(file, name.c_str(), type.id(), space.id(), H5P_DEFAULT, creation.id(),
                    H5P_DEFAULT);
}

}  // namespace gabion
