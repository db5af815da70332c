! SPDX-License-Identifier: BSD-3-Clause
! Linear elasticity as a user material: PROPS = Young's modulus [Pa], Poisson's ratio.
! gfortran -shared -fPIC -O2 -o liblinear_elastic.so linear_elastic.f90
subroutine umat(stress, statev, ddsdde, sse, spd, scd, rpl, ddsddt, drplde, drpldt, stran, dstran, time, dtime, temp, &
                dtemp, predef, dpred, cmname, ndi, nshr, ntens, nstatv, props, nprops, coords, drot, pnewdt, celent, &
                dfgrd0, dfgrd1, noel, npt, layer, kspt, kstep, kinc)
  implicit none
  character(len=80) :: cmname
  integer :: ndi, nshr, ntens, nstatv, nprops, noel, npt, layer, kspt, kstep, kinc
  double precision :: stress(ntens), statev(nstatv), ddsdde(ntens, ntens), sse, spd, scd, rpl, ddsddt(ntens), &
                      drplde(ntens), drpldt, stran(ntens), dstran(ntens), time(2), dtime, temp, dtemp, predef(1), &
                      dpred(1), props(nprops), coords(3), drot(3, 3), pnewdt, celent, dfgrd0(3, 3), dfgrd1(3, 3)
  double precision :: lambda, mu
  integer :: k

  mu = props(1) / (2d0 * (1d0 + props(2)))
  lambda = 2d0 * mu * props(2) / (1d0 - 2d0 * props(2))
  ddsdde = 0d0
  ddsdde(1:ndi, 1:ndi) = lambda
  do k = 1, ndi
    ddsdde(k, k) = lambda + 2d0 * mu
  end do
  do k = ndi + 1, ntens
    ddsdde(k, k) = mu
  end do
  stress = stress + matmul(ddsdde, dstran)
  sse = 0.5d0 * dot_product(stress, stran + dstran)
end subroutine umat
