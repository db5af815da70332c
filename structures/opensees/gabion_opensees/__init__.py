# SPDX-License-Identifier: BSD-3-Clause
"""OpenSees as the structure of a coupled run."""
