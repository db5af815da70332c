# SPDX-License-Identifier: BSD-3-Clause
"""Wet surfaces of beams and shells: points that nodes with rotations carry at a distance.

    surface = outline(axis, left=0.005, right=0.005, ends=(0, 4))       a line in the plane
    surface = shell(nodes, facets, above=0.01, below=0.01, rim=True)    a mid-surface
    surface = tube(axis, rectangle(0.1, 0.2), upwards=(0, 0, 1))        a line in space

Point k has x_k = X[carrier] + offset, and moves by u[carrier] + (R - I) offset, R the rotation of its node, of any
size. Its virtual displacement is du + dphi x arm, arm = R offset, dphi the spin; so by virtual work a force f on it is
f on the node and the moment arm x f. Force, moment and virtual work are those of the points, to rounding.
"""

from dataclasses import dataclass

import numpy as np

from .solver import END_OF_STEP, InterfaceMesh


@dataclass(frozen=True)
class OffsetSurface:
    """carrier: num_points, from 0; offset: [m] num_points x dim, in the reference configuration;
    nodes: [m] num_nodes x dim; facets: num_facets x 2, 3 or 4 points, their normals out of the structure."""

    nodes: np.ndarray
    carrier: np.ndarray
    offset: np.ndarray
    facets: np.ndarray

    @property
    def coordinates(self) -> np.ndarray:
        """[m] num_points x dim."""
        return self.nodes[self.carrier] + self.offset

    def interface(self, name: str, force_kind: str = END_OF_STEP) -> InterfaceMesh:
        return InterfaceMesh(name, self.coordinates, self.facets, force_kind)

    def arms(self, rotation: np.ndarray | None) -> np.ndarray:
        """R offset [m], num_points x dim. rotation: of the nodes, as rotation_matrices takes it; None: nodes without
        rotations, which carry their points in parallel."""
        if rotation is None:
            return self.offset
        matrices = rotation_matrices(rotation, self.nodes.shape[1])
        return np.einsum("kij,kj->ki", matrices[self.carrier], self.offset)

    def displacement(self, u: np.ndarray, rotation: np.ndarray | None) -> np.ndarray:
        """[m] of the points, num_points x dim; u: [m] of the nodes, num_nodes x dim."""
        moved = np.asarray(u)[self.carrier]
        return moved if rotation is None else moved + (self.arms(rotation) - self.offset)

    def forces(self, force: np.ndarray) -> np.ndarray:
        """[N] on the nodes, num_nodes x dim, of forces on the points, num_points x dim."""
        total = np.zeros(self.nodes.shape)
        np.add.at(total, self.carrier, force)
        return total

    def moments(self, force: np.ndarray, arms: np.ndarray) -> np.ndarray:
        """[N m] on the nodes about axes fixed in space: num_nodes x 3, in 2D num_nodes (counter-clockwise).

        arms: those at the instant of the force. With the mean of those before and after a step the work of a force
        that is constant over the step is exact: f . (p' - p) = f . (u' - u) + moment . 2 tan(angle / 2) n, which
        differs from angle n, the rotation of the step, by a twelfth of its square.
        """
        if self.nodes.shape[1] == 2:
            total = np.zeros(len(self.nodes))
            np.add.at(total, self.carrier, arms[:, 0] * force[:, 1] - arms[:, 1] * force[:, 0])
            return total
        total = np.zeros(self.nodes.shape)
        np.add.at(total, self.carrier, np.cross(arms, force))
        return total


def rotation_matrices(rotation: np.ndarray, dimension: int) -> np.ndarray:
    """num x dim x dim, of angles (2D: num, counter-clockwise [rad]), of rotation vectors (3D: num x 3, axis times
    angle; Rodrigues) or of matrices, which stay."""
    rotation = np.asarray(rotation, dtype=float)
    if rotation.ndim == 3:
        return rotation
    if dimension == 2:
        c, s = np.cos(rotation), np.sin(rotation)
        return np.stack([np.stack([c, -s], axis=-1), np.stack([s, c], axis=-1)], axis=-2)
    angle = np.linalg.norm(rotation, axis=1)[:, None, None]
    x, y, z = rotation.T
    zero = np.zeros_like(x)
    skew = np.stack([zero, -z, y, z, zero, -x, -y, x, zero], axis=-1).reshape(-1, 3, 3)
    # sin(a) / a and (1 - cos(a)) / a^2, without cancellation
    return np.eye(3) + np.sinc(angle / np.pi) * skew + 0.5 * np.sinc(0.5 * angle / np.pi)**2 * (skew @ skew)


def turned(matrices: np.ndarray, spin: np.ndarray) -> np.ndarray:
    """Rotations after one more, spin [rad] (num x 3, about axes fixed in space): exp(spin) R. For codes whose
    rotational unknowns in 3D are sums of spins, which are no rotation vector once the axis has turned."""
    return rotation_matrices(spin, 3) @ matrices


def outline(axis: np.ndarray, left: float | None = None, right: float | None = None,
            ends: tuple[int, int] = (0, 0)) -> OffsetSurface:
    """Surface around a line in the plane, num_nodes x 2: its face on the left and on the right in the
    direction of the line, at these distances [m] (None: dry; 0: the line itself), parallel to the line at its
    bends. ends: in how many segments the first and last end are closed, 0: open; of two wet faces only.

    Order: the right face along the line, the last end, the left face back, the first end.
    """
    axis = np.asarray(axis, dtype=float)
    if axis.ndim != 2 or axis.shape[1] != 2 or len(axis) < 2:
        raise ValueError(f"outline: found an axis of shape {axis.shape}, allowed: num_nodes x 2, two nodes at least")
    if left is None and right is None or any(ends) and None in (left, right):
        raise ValueError(f"outline: found left {left}, right {right}, ends {ends}, allowed: a wet face, two with ends")
    across = bisectors(axis)  # to the left
    last = len(axis) - 1
    points: list[tuple[int, float]] = []  # carrier, distance to the left
    if right is not None:
        points += [(node, -right) for node in range(last + 1)]
    if ends[1]:
        points += [(last, distance) for distance in np.linspace(-right, left, ends[1] + 1)[1:-1]]
    faces = [len(points)]
    if left is not None:
        points += [(node, left) for node in range(last, -1, -1)]
    if ends[0]:
        points += [(0, distance) for distance in np.linspace(left, -right, ends[0] + 1)[1:-1]]
    carrier = np.array([node for node, _ in points])
    offset = np.array([distance for _, distance in points])[:, None] * across[carrier]
    way = np.arange(len(points))
    facets = np.stack([way, np.roll(way, -1)], axis=1)
    gaps = {faces[0] - 1} if right is not None and left is not None and not ends[1] else set()
    gaps |= set() if ends[0] else {len(points) - 1}
    return OffsetSurface(axis, carrier, offset, facets[[k for k in way if k not in gaps]])


def bisectors(axis: np.ndarray) -> np.ndarray:
    """Vectors to the left of the nodes of a line, num_nodes x 2: of length 1, at bends so long that their ends lie on
    parallels at the distance 1. Raises ValueError where the line turns back."""
    way = np.diff(axis, axis=0)
    lengths = np.linalg.norm(way, axis=1, keepdims=True)
    if not (lengths > 0).all():
        raise ValueError("outline: found two nodes at one place, allowed: different ones")
    normal = np.stack([-way[:, 1], way[:, 0]], axis=1) / lengths
    before, after = np.vstack([normal[:1], normal]), np.vstack([normal, normal[-1:]])
    one_plus_cosine = 1 + np.sum(before * after, axis=1, keepdims=True)
    if (one_plus_cosine < 0.03).any():
        raise ValueError("outline: found a line that turns back, allowed: bends of less than 165 degrees")
    return (before + after) / one_plus_cosine


def shell(nodes: np.ndarray, facets: np.ndarray, above: float | None = None, below: float | None = None,
          rim: bool = False) -> OffsetSurface:
    """Surface around a mid-surface: nodes num_nodes x 3, facets num_facets x 3 or 4 with normals by the right
    hand. Its faces along the normal (above) and against it (below) at these distances [m] (None: dry), and
    the free edges between two wet faces (rim)."""
    nodes, facets = np.asarray(nodes, dtype=float), np.asarray(facets)
    if above is None and below is None or rim and None in (above, below):
        raise ValueError(f"shell: found above {above}, below {below}, rim {rim}, allowed: a wet face, two with a rim")
    normal = nodal_normals(nodes, facets)
    used = np.unique(facets)
    place = np.full(len(nodes), -1)
    place[used] = np.arange(len(used))
    distances = ([] if above is None else [above]) + ([] if below is None else [-below])
    carrier = np.tile(used, len(distances))
    offset = np.repeat(distances, len(used))[:, None] * normal[carrier]
    parts = [] if above is None else [place[facets]]
    shift = 0 if above is None else len(used)
    if below is not None:
        parts.append(place[facets][:, ::-1] + shift)
    if rim:
        edges = place[free_edges(facets)]
        quads = np.stack([edges[:, 1], edges[:, 0], edges[:, 0] + shift, edges[:, 1] + shift], axis=1)
        parts.append(quads if facets.shape[1] == 4 else triangles(quads))
    return OffsetSurface(nodes, carrier, offset, np.vstack(parts))


def nodal_normals(nodes: np.ndarray, facets: np.ndarray) -> np.ndarray:
    """Mean of the facets' unit normals, num_nodes x 3, so long that its part along them is 1 in the mean; 0 at nodes
    without facets."""
    corners = nodes[facets]
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]) if facets.shape[1] == 3 else \
        np.cross(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1])
    size = np.linalg.norm(across, axis=1, keepdims=True)
    if not (size > 0).all():
        raise ValueError("shell: found a facet without area")
    unit = across / size
    total, count = np.zeros(nodes.shape), np.zeros(len(nodes))
    for corner in facets.T:
        np.add.at(total, corner, unit)
        np.add.at(count, corner, 1)
    square = np.sum(total**2, axis=1)
    used = count > 0
    if (square[used] < 0.03 * count[used]**2).any():
        raise ValueError("shell: found facets whose normals point against each other at a node")
    total[used] *= (count[used] / square[used])[:, None]
    return total


def free_edges(facets: np.ndarray) -> np.ndarray:
    """Edges of one facet only, num x 2, in that facet's direction."""
    edges = np.stack([facets, np.roll(facets, -1, axis=1)], axis=-1).reshape(-1, 2)
    _, index, count = np.unique(np.sort(edges, axis=1), axis=0, return_inverse=True, return_counts=True)
    return edges[count[index.ravel()] == 1]


def tube(axis: np.ndarray, section: np.ndarray, upwards: tuple[float, float, float], closed: bool = True,
         ends: bool = False) -> OffsetSurface:
    """Surface around a line in space, num_nodes x 3: a polygon (num x 2, [m]) along it. The polygon's first
    axis is `upwards`, made normal to the line, its second one completes the right hand of (direction, first,
    second); the polygon runs from the first to the second. closed: back to its first corner; else an open
    strip. ends: with lids, all in triangles."""
    axis, section = np.asarray(axis, dtype=float), np.asarray(section, dtype=float)
    way = np.diff(axis, axis=0)
    way /= np.linalg.norm(way, axis=1, keepdims=True)
    tangent = np.vstack([way[:1], way[1:] + way[:-1], way[-1:]])
    tangent /= np.linalg.norm(tangent, axis=1, keepdims=True)
    first = np.array(upwards, dtype=float) - (tangent @ np.array(upwards, dtype=float))[:, None] * tangent
    length = np.linalg.norm(first, axis=1, keepdims=True)
    if not (length > 1e-3 * np.linalg.norm(upwards)).all():
        raise ValueError(f"tube: found upwards {tuple(upwards)} along the line, allowed: across it")
    first /= length
    second = np.cross(tangent, first)
    count, corners = len(axis), len(section)
    offset = section[None, :, :1] * first[:, None] + section[None, :, 1:] * second[:, None]
    carrier = np.repeat(np.arange(count), corners)
    i, k = np.meshgrid(np.arange(count - 1), np.arange(corners if closed else corners - 1), indexing="ij")
    i, k, after = i.ravel(), k.ravel(), (k.ravel() + 1) % corners
    quads = np.stack([i * corners + k, i * corners + after, (i + 1) * corners + after, (i + 1) * corners + k], axis=1)
    if not ends:
        return OffsetSurface(axis, carrier, offset.reshape(-1, 3), quads)
    if not closed:
        raise ValueError("tube: found ends of an open strip, allowed: of a closed section")
    k, after = np.arange(corners), (np.arange(corners) + 1) % corners
    begin, end = np.full(corners, count * corners), np.full(corners, count * corners + 1)
    top = (count - 1) * corners
    lids = np.vstack([np.stack([begin, after, k], axis=1), np.stack([end, top + k, top + after], axis=1)])
    middle = offset.mean(axis=1)[[0, -1]]
    return OffsetSurface(axis, np.append(carrier, [0, count - 1]), np.vstack([offset.reshape(-1, 3), middle]),
                         np.vstack([triangles(quads), lids]))


def triangles(quads: np.ndarray) -> np.ndarray:
    return np.vstack([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])


def rectangle(first: float, second: float, segments: tuple[int, int] = (1, 1)) -> np.ndarray:
    """Section of tube(): sides [m] along its first and second axis, each in segments; num x 2."""
    a, b = np.linspace(-0.5, 0.5, segments[0] + 1) * first, np.linspace(-0.5, 0.5, segments[1] + 1) * second
    sides = [np.stack([np.full(segments[1], a[-1]), b[:-1]], axis=1),
             np.stack([a[:0:-1], np.full(segments[0], b[-1])], axis=1),
             np.stack([np.full(segments[1], a[0]), b[:0:-1]], axis=1),
             np.stack([a[:-1], np.full(segments[0], b[0])], axis=1)]
    return np.vstack(sides)


def circle(radius: float, corners: int) -> np.ndarray:
    """Section of tube(): a regular polygon with the area of the circle; num x 2."""
    angle = 2 * np.pi * np.arange(corners) / corners
    scale = radius * np.sqrt(2 * np.pi / (corners * np.sin(2 * np.pi / corners)))
    return scale * np.stack([np.cos(angle), np.sin(angle)], axis=1)
