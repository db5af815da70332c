# SPDX-License-Identifier: BSD-3-Clause
"""The page that scripts/report writes on a run."""
