// SPDX-License-Identifier: BSD-3-Clause
#include "frames.hpp"

#include <deal.II/numerics/data_out.h>

#include <common/base/error.hpp>

#include <filesystem>
#include <fstream>

namespace dealii_structure {

template <int dim>
Frames<dim>::Frames(std::string folder) : folder_(std::move(folder)) {
  std::filesystem::create_directories(folder_);
}

template <int dim>
void Frames<dim>::write(double time, const ElasticSolid<dim>& solid, const Vector& u,
                        const Vector& v) {
  dealii::DataOut<dim> out;
  out.attach_dof_handler(solid.dofs());
  using dealii::DataComponentInterpretation::component_is_part_of_vector;
  const std::vector<dealii::DataComponentInterpretation::DataComponentInterpretation> parts(
      dim, component_is_part_of_vector);
  out.add_data_vector(u, std::vector<std::string>(dim, "displacement"),
                      dealii::DataOut<dim>::type_dof_data, parts);
  out.add_data_vector(v, std::vector<std::string>(dim, "velocity"),
                      dealii::DataOut<dim>::type_dof_data, parts);
  out.build_patches(solid.dofs().get_fe().degree);
  const std::string number = std::to_string(written_.size());
  const std::string name =
      "frame_" + std::string(4 - std::min<std::size_t>(4, number.size()), '0') + number + ".vtu";
  std::ofstream file(folder_ + "/" + name);
  out.write_vtu(file);
  if (!file) throw gabion::Error(folder_ + "/" + name + ": cannot be written");
  written_.emplace_back(time, name);
  std::ofstream list(folder_ + "/frames.pvd");
  dealii::DataOutBase::write_pvd_record(list, written_);
}

template class Frames<2>;
template class Frames<3>;

}  // namespace dealii_structure
