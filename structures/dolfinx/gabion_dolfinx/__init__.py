# SPDX-License-Identifier: BSD-3-Clause
"""A variational form of dolfinx as the structure of a coupled run: derive from Model."""

from .model import Model, ModelError

__all__ = ["Model", "ModelError"]
