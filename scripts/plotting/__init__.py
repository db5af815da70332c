# SPDX-License-Identifier: BSD-3-Clause
"""Plots of a results folder. The program is scripts/plot."""
