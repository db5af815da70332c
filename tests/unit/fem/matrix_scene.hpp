// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <memory>
#include <string>

#include "fem_solver/matrices/matrix_solver.hpp"
#include "fem_solver/matrices/write_matrices.hpp"
#include "tests/unit/fem/fem_scene.hpp"

namespace gabion::test {

/// A scene of a structure as matrices, in a folder that vanishes with this object.
class MatrixScene {
 public:
  /// An empty folder.
  MatrixScene() : folder_(make_folder()) {}
  /// A scene with the files that write_matrices() writes for a structure with a mesh.
  template <int dim>
  static MatrixScene of(const Json& with_mesh) {
    MatrixScene scene;
    Json resolved = with_mesh;  // its defaults are those of the reader
    fem::write_matrices<dim>(fem_settings<dim>(with_mesh), resolved, comm(), scene.folder_);
    std::ifstream(scene.path("fem.json")) >> scene.json;
    return scene;
  }
  ~MatrixScene() {
    if (!folder_.empty()) std::filesystem::remove_all(folder_);
  }
  MatrixScene(const MatrixScene&) = delete;
  MatrixScene& operator=(const MatrixScene&) = delete;
  MatrixScene(MatrixScene&& other) noexcept
      : json(std::move(other.json)), folder_(std::exchange(other.folder_, "")) {}
  MatrixScene& operator=(MatrixScene&&) = delete;

  std::string path(const std::string& file) const { return folder_ + "/" + file; }
  void write(const std::string& file, const std::string& text) const {
    std::ofstream(path(file)) << text;
  }
  /// The solver of `json`. @param output_folder  of the frames; empty: none
  template <int dim>
  std::unique_ptr<fem::MatrixSolver<dim>> solver(const std::string& output_folder = "") const {
    std::ofstream(path("fem.json")) << json.dump();
    const Scene scene(folder_, {});
    ConfigReader in = scene.reader("fem.json", fem::fem_keys());
    fem::read_dimension(in);
    auto settings = fem::read_matrix_settings<dim>(in);
    in.finish();
    return std::make_unique<fem::MatrixSolver<dim>>(comm(), scene, settings, output_folder);
  }

  Json json;  ///< fem.json

 private:
  static std::string make_folder() {
    static int count = 0;
    const auto folder =
        std::filesystem::temp_directory_path() /
        ("gabion_matrices_" + std::to_string(getpid()) + "_" + std::to_string(++count));
    std::filesystem::create_directories(folder);
    return folder.string();
  }
  std::string folder_;
};

/// Two masses [kg] on two springs [N/m] in x between a wall and each other, nodes 1 and 2 of the
/// plane; node 3 is the wall; nothing moves in y. Surface "wall" from node 2 to node 1.
inline MatrixScene two_masses() {
  MatrixScene scene;
  scene.write("K.mtx",
              "%%MatrixMarket matrix coordinate real symmetric\n% a comment\n2 2 3\n"
              "1 1 30\n2 1 -10\n2 2 10\n");
  scene.write("M.mtx", "%%MatrixMarket matrix coordinate real general\n2 2 2\n1 1 2.0\n2 2 1e0\n");
  scene.write("unknowns.csv", "node,direction\n1,1\n2,1\n");
  scene.write("held.csv", "1,2\n2,2\n3\n");
  scene.write("nodes.csv", "node,x,y\n3,0,0\n1,1,0\n2,2,0\n");
  scene.write("wall.csv", "# facets\n2 1\n");
  scene.json = {{"dimension", 2},
                {"matrices",
                 {{"stiffness", "K.mtx"},
                  {"mass", "M.mtx"},
                  {"unknowns", "unknowns.csv"},
                  {"held", "held.csv"},
                  {"nodes", "nodes.csv"}}},
                {"interfaces", {{{"name", "wall"}, {"facets", "wall.csv"}}}},
                {"probes", {{{"name", "A"}, {"point", {2, 0}}}}}};
  return scene;
}

}  // namespace gabion::test
