# SPDX-License-Identifier: BSD-3-Clause
"""The verification table: run the problems, read what they found, write table and figures."""
