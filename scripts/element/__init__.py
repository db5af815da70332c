# SPDX-License-Identifier: BSD-3-Clause
"""Tests of the laboratory on one element: what scripts/element-test and scripts/calibrate share."""
