# SPDX-License-Identifier: BSD-3-Clause
"""CalculiX as the structure of a coupled run: an input deck and structure.json, no program of one's own."""
