/* SPDX-License-Identifier: BSD-3-Clause
 * Von Mises plasticity with linear hardening as a user material, by radial return with its exact tangent.
 * PROPS: Young's modulus [Pa], Poisson's ratio, yield stress [Pa], hardening modulus [Pa].
 * STATEV: equivalent plastic strain.
 * cc -shared -fPIC -O2 -o libvon_mises.so von_mises.c -lm
 */
#include <math.h>
#include <stddef.h>

void umat_(double* stress, double* statev, double* ddsdde, double* sse, double* spd, double* scd, double* rpl,
           double* ddsddt, double* drplde, double* drpldt, const double* stran, const double* dstran,
           const double* time, const double* dtime, const double* temp, const double* dtemp, const double* predef,
           const double* dpred, const char* cmname, const int* ndi, const int* nshr, const int* ntens,
           const int* nstatv, const double* props, const int* nprops, const double* coords, const double* drot,
           double* pnewdt, const double* celent, const double* dfgrd0, const double* dfgrd1, const int* noel,
           const int* npt, const int* layer, const int* kspt, const int* kstep, const int* kinc, size_t length) {
  const int n = *ntens, normal = *ndi;
  const double mu = props[0] / (2 * (1 + props[1])), bulk = props[0] / (3 * (1 - 2 * props[1]));
  double s[6], pressure = 0, square = 0, volume = 0;

  for (int k = 0; k < normal; ++k) volume += dstran[k];
  for (int k = 0; k < n; ++k) /* elastic step; shear strains are angles */
    stress[k] += k < normal ? 2 * mu * (dstran[k] - volume / 3) + bulk * volume : mu * dstran[k];
  for (int k = 0; k < normal; ++k) pressure += stress[k] / normal;
  for (int k = 0; k < n; ++k) {
    s[k] = k < normal ? stress[k] - pressure : stress[k];
    square += (k < normal ? 1 : 2) * s[k] * s[k];
  }
  const double q = sqrt(1.5 * square), yield = props[2] + props[3] * statev[0];
  const int plastic = q > yield;
  const double slip = plastic ? (q - yield) / (3 * mu + props[3]) : 0; /* equivalent plastic strain */
  const double ratio = plastic ? 1 - 3 * mu * slip / q : 1;
  statev[0] += slip;
  for (int k = 0; k < n; ++k) stress[k] = ratio * s[k] + (k < normal ? pressure : 0);

  const double along = plastic ? 9 * mu * mu * (slip / q - 1 / (3 * mu + props[3])) / (q * q) : 0;
  for (int l = 0; l < n; ++l) {
    for (int k = 0; k < n; ++k) {
      double c = along * s[k] * s[l];
      if (k == l) c += (k < normal ? 2 : 1) * mu * ratio;
      if (k < normal && l < normal) c += bulk - 2 * mu * ratio / 3;
      ddsdde[k + n * l] = c;
    }
  }
  (void)sse, (void)spd, (void)scd, (void)rpl, (void)ddsddt, (void)drplde, (void)drpldt, (void)stran, (void)time;
  (void)dtime, (void)temp, (void)dtemp, (void)predef, (void)dpred, (void)cmname, (void)nshr, (void)nstatv;
  (void)nprops, (void)coords, (void)drot, (void)pnewdt, (void)celent, (void)dfgrd0, (void)dfgrd1, (void)noel;
  (void)npt, (void)layer, (void)kspt, (void)kstep, (void)kinc, (void)length;
}
