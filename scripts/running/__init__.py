# SPDX-License-Identifier: BSD-3-Clause
"""Starting programs: what scripts/run and all that launches mpirun itself share."""
