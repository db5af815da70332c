# SPDX-License-Identifier: BSD-3-Clause
"""Least squares of parameters against measurements: of a law against a laboratory, of a scene against what was
measured."""
