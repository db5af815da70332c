# SPDX-License-Identifier: BSD-3-Clause
"""Studies over several runs. The program is scripts/bench."""
