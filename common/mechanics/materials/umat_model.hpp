// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <array>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace gabion {

/// Most state variables (STATEV) that a user material may have.
inline constexpr int most_umat_variables = 40;

/// Places behind PROPS and STATEV that a user material may use by mistake without a crash.
inline constexpr int umat_room = 64;

/// Meaning of DDSDDE: derivative of the Cauchy stress, as most user materials have it, or that of J
/// sigma over J, as the manual of Abaqus asks for.
enum class UmatTangent { cauchy, kirchhoff };

/// Settings of a user material.
struct UmatSettings {
  std::string where;                      ///< in the settings, for messages
  std::string library;                    ///< path of the shared library
  std::string name;                       ///< CMNAME
  std::vector<double> constants;          ///< PROPS
  std::vector<double> initial_variables;  ///< STATEV of virgin soil
};

/// Input of one call. Tensors have true components, in the order xx yy zz xy (yz xz) of the
/// project; all of them are those at the start of the increment, turned by `rotation`.
struct UmatCall {
  using Vector6 = Eigen::Matrix<double, 6, 1>;
  Vector6 stress = Vector6::Zero();                        ///< Cauchy [Pa]
  Vector6 strain = Vector6::Zero();                        ///< STRAN, sum of the increments
  Vector6 increment = Vector6::Zero();                     ///< DSTRAN
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();  ///< DROT, of the increment
  Eigen::Matrix3d F0 = Eigen::Matrix3d::Identity();        ///< DFGRD0
  Eigen::Matrix3d F1 = Eigen::Matrix3d::Identity();        ///< DFGRD1
  std::span<const double> variables{};                     ///< STATEV
  std::span<const double> constants{};  ///< PROPS and umat_room more; empty: those of the model
  double behind_variables = 0;          ///< what lies behind STATEV
  double energy = 0;                    ///< SSE [J/m^3]
  double time = 0, dt = 0;              ///< [s]
  double length = 1;                    ///< CELENT [m]
  int number = 1;                       ///< KINC
};

/// Answer of the user material, in the order of UmatCall.
struct UmatAnswer {
  using Matrix6 = Eigen::Matrix<double, 6, 6>;
  UmatCall::Vector6 stress = UmatCall::Vector6::Zero();  ///< Cauchy [Pa]
  /// Derivative of the stress by the true components of the increment [Pa].
  Matrix6 tangent = Matrix6::Zero();
  std::array<double, most_umat_variables> variables{};
  double energy = 0;     ///< SSE [J/m^3]
  double share = 1;      ///< PNEWDT: < 1 asks for a shorter step
  bool overrun = false;  ///< wrote behind STATEV
  bool finite() const;
};

/// A shared library with a subroutine UMAT, and the constants of one material.
class UmatModel {
 public:
  /// Load the library and check what the subroutine answers: docs/umat.md.
  /// @param dim  3, or 2 for plane strain (NDI 3, NSHR 1)
  /// @throws ConfigError  no such library or subroutine; it answers with numbers that are not
  ///                      finite, or twice differently; warnings of what makes Newton's method slow
  UmatModel(UmatSettings settings, int dim);
  ~UmatModel();
  UmatModel(const UmatModel&) = delete;
  UmatModel& operator=(const UmatModel&) = delete;
  UmatModel(UmatModel&&) = delete;
  UmatModel& operator=(UmatModel&&) = delete;

  UmatAnswer call(const UmatCall& call) const;

  /// PROPS, then umat_room zeros.
  const std::vector<double>& constants() const { return constants_; }
  int num_variables() const { return static_cast<int>(settings_.initial_variables.size()); }
  const std::vector<double>& initial_variables() const { return settings_.initial_variables; }
  /// Tangent of virgin soil without strain [Pa].
  const UmatAnswer::Matrix6& stiffness() const { return stiffness_; }
  UmatTangent tangent() const { return tangent_; }
  int size() const { return dim_ == 2 ? 4 : 6; }  ///< NTENS

 private:
  void open();
  void check();
  void check_finite(const UmatAnswer& answer, const char* of) const;
  void check_room() const;
  void check_precision() const;

  UmatSettings settings_;
  std::vector<double> constants_;
  int dim_;
  void* library_ = nullptr;
  void* function_ = nullptr;
  UmatTangent tangent_ = UmatTangent::cauchy;
  UmatAnswer::Matrix6 stiffness_ = UmatAnswer::Matrix6::Zero();
};

}  // namespace gabion
