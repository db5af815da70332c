/* SPDX-License-Identifier: BSD-3-Clause
 * Elastic user material with a fault by PROPS(1): 1 a stress that is no number, 2 a SAVE, 3 the wrong tangent, 4 a
 * tangent of J sigma, 5 stiff in fixed axes, 6 a step that is too long beyond a strain of 0.05, 7 none: STATEV(1) is
 * CELENT, 8 no step without time. */
#include <math.h>
#include <stddef.h>

void UMAT(double* stress, double* statev, double* ddsdde, double* sse, double* spd, double* scd, double* rpl,
          double* ddsddt, double* drplde, double* drpldt, const double* stran, const double* dstran,
          const double* time, const double* dtime, const double* temp, const double* dtemp, const double* predef,
          const double* dpred, const char* cmname, const int* ndi, const int* nshr, const int* ntens,
          const int* nstatv, const double* props, const int* nprops, const double* coords, const double* drot,
          double* pnewdt, const double* celent, const double* dfgrd0, const double* dfgrd1, const int* noel,
          const int* npt, const int* layer, const int* kspt, const int* kstep, const int* kinc, size_t length) {
  static double calls = 0;
  const int fault = (int)props[0], n = *ntens;
  const double lambda = 1e6, mu = 1e6, more = fault == 5 ? 1e6 : 0;
  for (int l = 0; l < n; ++l)
    for (int k = 0; k < n; ++k) {
      double c = k < 3 && l < 3 ? lambda : 0;
      if (k == l) c += k < 3 ? 2 * mu : mu;
      if (k == 0 && l == 0) c += more;
      ddsdde[k + n * l] = c;
    }
  for (int k = 0; k < n; ++k)
    for (int l = 0; l < n; ++l) stress[k] += ddsdde[k + n * l] * dstran[l];
  if (fault == 1) stress[0] = NAN;
  if (fault == 2) stress[0] += ++calls;
  if (fault == 3) ddsdde[0] *= 1.5;
  if (fault == 4)
    for (int l = 0; l < 3; ++l)
      for (int k = 0; k < n; ++k) ddsdde[k + n * l] += stress[k];
  if (fault == 6 && fabs(dstran[0]) > 0.05) *pnewdt = 0.25;
  if (fault == 7) statev[0] = *celent;
  if (fault == 8 && *dtime == 0) *pnewdt = 0.5;
  (void)statev, (void)sse, (void)spd, (void)scd, (void)rpl, (void)ddsddt, (void)drplde, (void)drpldt, (void)stran;
  (void)time, (void)dtime, (void)temp, (void)dtemp, (void)predef, (void)dpred, (void)cmname, (void)ndi, (void)nshr;
  (void)nstatv, (void)nprops, (void)coords, (void)drot, (void)celent, (void)dfgrd0, (void)dfgrd1, (void)noel;
  (void)npt, (void)layer, (void)kspt, (void)kstep, (void)kinc, (void)length;
}
