# SPDX-License-Identifier: BSD-3-Clause
"""Studies of a scene over its settings by a plan. The program is scripts/study."""
