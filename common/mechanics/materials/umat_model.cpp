// SPDX-License-Identifier: BSD-3-Clause
#include "common/mechanics/materials/umat_model.hpp"

#include <dlfcn.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "common/base/error.hpp"
#include "common/base/require.hpp"

namespace gabion {
namespace {

// Interface of a UMAT, as Fortran compilers have it: all by reference, the hidden length of the
// name last (gfortran from 8 on: size_t).
extern "C" {
using UmatFunction = void(double* STRESS, double* STATEV, double* DDSDDE, double* SSE, double* SPD,
                          double* SCD, double* RPL, double* DDSDDT, double* DRPLDE, double* DRPLDT,
                          const double* STRAN, const double* DSTRAN, const double* TIME,
                          const double* DTIME, const double* TEMP, const double* DTEMP,
                          const double* PREDEF, const double* DPRED, const char* CMNAME,
                          const int* NDI, const int* NSHR, const int* NTENS, const int* NSTATV,
                          const double* PROPS, const int* NPROPS, const double* COORDS,
                          const double* DROT, double* PNEWDT, const double* CELENT,
                          const double* DFGRD0, const double* DFGRD1, const int* NOEL,
                          const int* NPT, const int* LAYER, const int* KSPT, const int* KSTEP,
                          const int* KINC, std::size_t length_of_CMNAME);
}

constexpr int name_length = 80;

// Place of each component in the order 11 22 33 12 13 23 of Abaqus.
constexpr std::array<int, 6> places = {0, 1, 2, 3, 5, 4};

// Factor of a strain's component there: shear strains are angles.
constexpr double strain_factor(int k) {
  return k < 3 ? 1 : 2;
}

}  // namespace

bool UmatAnswer::finite() const {
  return stress.allFinite() && tangent.allFinite() && std::isfinite(energy) &&
         std::isfinite(share) &&
         std::ranges::all_of(variables, [](double x) { return std::isfinite(x); });
}

UmatModel::UmatModel(UmatSettings settings, int dim)
    : settings_(std::move(settings)), constants_(settings_.constants), dim_(dim) {
  constants_.resize(constants_.size() + umat_room, 0.0);
  open();
  check();
}

UmatModel::~UmatModel() = default;  // other materials may have the library too: it stays loaded

void UmatModel::open() {
  const std::string& path = settings_.library;
  library_ = dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (library_ == nullptr) {
    throw ConfigError(settings_.where + "/library: found " + path + ", which cannot be loaded: " +
                      dlerror() + "; allowed: a shared library for this machine");
  }
  for (const char* symbol : {"umat_", "umat", "UMAT"}) {
    function_ = dlsym(library_, symbol);
    if (function_ != nullptr) return;
  }
  throw ConfigError(settings_.where + "/library: found " + path +
                    " without any of umat_, umat, UMAT, allowed: a library with such a subroutine");
}

UmatAnswer UmatModel::call(const UmatCall& call) const {
  const int n = size();
  std::array<double, 6> stress{}, stran{}, dstran{}, ddsddt{}, drplde{};
  std::array<double, 36> ddsdde{};
  for (int k = 0; k < n; ++k) {
    stress[places[k]] = call.stress[k];
    stran[places[k]] = strain_factor(k) * call.strain[k];
    dstran[places[k]] = strain_factor(k) * call.increment[k];
  }
  UmatAnswer answer;
  std::array<double, most_umat_variables + umat_room> statev, behind;
  behind.fill(call.behind_variables);
  statev = behind;
  std::ranges::copy(call.variables, statev.begin());
  const double* props = call.constants.empty() ? constants_.data() : call.constants.data();
  answer.energy = call.energy;
  double spd = 0, scd = 0, rpl = 0, drpldt = 0;
  const double none = 0;
  const std::array<double, 2> time = {call.time, call.time};
  const std::array<double, 3> coords{};
  std::array<char, name_length> name;
  name.fill(' ');
  std::memcpy(name.data(), settings_.name.data(), std::min(settings_.name.size(), name.size()));
  const int ndi = 3, nshr = n - 3, nstatv = num_variables(), one = 1;
  const int nprops = static_cast<int>(settings_.constants.size());
  double share = 1;
  reinterpret_cast<UmatFunction*>(function_)(
      stress.data(), statev.data(), ddsdde.data(), &answer.energy, &spd, &scd, &rpl, ddsddt.data(),
      drplde.data(), &drpldt, stran.data(), dstran.data(), time.data(), &call.dt, &none, &none,
      &none, &none, name.data(), &ndi, &nshr, &n, &nstatv, props, &nprops, coords.data(),
      call.rotation.data(), &share, &call.length, call.F0.data(), call.F1.data(), &one, &one, &one,
      &one, &one, &call.number, name.size());
  answer.share = share;
  std::copy_n(statev.begin(), nstatv, answer.variables.begin());
  answer.overrun = std::memcmp(statev.data() + nstatv, behind.data() + nstatv,
                               (statev.size() - nstatv) * sizeof(double)) != 0;
  for (int k = 0; k < n; ++k) {
    answer.stress[k] = stress[places[k]];
    for (int l = 0; l < n; ++l) {
      answer.tangent(k, l) = ddsdde[places[k] + n * places[l]] * strain_factor(l);
    }
  }
  if (tangent_ == UmatTangent::kirchhoff) {
    for (int l = 0; l < 3; ++l) answer.tangent.col(l) -= answer.stress;
  }
  return answer;
}

}  // namespace gabion
