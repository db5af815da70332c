# SPDX-License-Identifier: BSD-3-Clause
"""The reader of sources of scripts/check_structure: functions with their lengths and parameters."""
