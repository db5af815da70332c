# SPDX-License-Identifier: BSD-3-Clause
"""What scripts/check_structure reads in sources: functions with their lengths and parameters."""
