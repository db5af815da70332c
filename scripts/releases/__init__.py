# SPDX-License-Identifier: BSD-3-Clause
"""Other releases of Debian and Ubuntu. The program is scripts/test_on."""
