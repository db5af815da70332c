/* SPDX-License-Identifier: BSD-3-Clause
 * A library without a user material. */
int no_umat(void) { return 0; }
